#pragma once

// The sparse linear algebra of this layer. Sources outside of this folder include only this header.
//
//   NormalEquations    N = J^T W J and the pattern of its blocks
//   Cholesky           elimination order, analysis, factorisation N = P^T L L^T P, solutions
//   SelectedInverse    entries of N^-1 within the pattern of L
//   GaussNewton        undamped steps of a network
//   SharedAnalysis     order, analysis and memory shared between networks of one structure
//   SerialBlas         one BLAS thread while an object of this class exists
//   NewZeros, Square   large dense arrays and their products

#include "sparse/cholesky.h"
#include "sparse/gauss_newton.h"
#include "sparse/large_array.h"
#include "sparse/normal_equations.h"
#include "sparse/selected_inverse.h"
#include "sparse/serial_blas.h"
#include "sparse/shared_analysis_impl.h"
#include "sparse/square.h"
