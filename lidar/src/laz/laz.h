#pragma once

/// Compressed points of LAZ files: the record that describes them, a reader and a writer.
///
/// Reads the compressors 1 to 3 of LASzip, with fixed and variable chunks, and so COPC. Writes
/// chunks of 50000 points: point by point for the point formats 0 to 5, in layers for 6 to 10.
///
/// Source: M. Isenburg, LASzip: lossless compression of LiDAR data, PE&RS 79(2), 2013; the LASzip
/// specification documents (https://laszip.org); COPC 1.0 (https://copc.io).

#include "chunk_table.h"
#include "compression.h"
#include "point_reader.h"
#include "point_writer.h"
