// The precompiled headers need a file that they are compiled with.
