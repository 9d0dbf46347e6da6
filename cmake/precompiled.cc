// Precompiled headers need a source file with which they are compiled.
