#pragma once

#include <ceres/jet.h>
#include <dn/eigen_alignment.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace dn {

/// Returns the NaN that marks residuals and Jacobians before a factor is evaluated. Its bit pattern
/// distinguishes a value that the factor did not write from a computed NaN.
inline double UnwrittenNan() { return std::bit_cast<double>(std::uint64_t{0x7ff8'0000'dead'beef}); }
inline bool IsUnwritten(double value) {
  return std::bit_cast<std::uint64_t>(value) == std::bit_cast<std::uint64_t>(UnwrittenNan());
}

/// The number type with which Differentiate calls a function of blocks of these sizes.
template <int... kSizes>
using BlockJet = ceres::Jet<double, (0 + ... + kSizes)>;

/// The number type with which DifferentiateDynamic calls a function: a few derivatives at a time.
inline constexpr int kDynamicStride = 6;
using DynamicJet = ceres::Jet<double, kDynamicStride>;

/// Computes the residual and Jacobians of `function(x, r)` by automatic differentiation. `function`
/// is a template over the number type of x and r, with R residuals and blocks of the given sizes.
/// Arguments and layout are those of FactorBase::Evaluate. Rows that the function does not write
/// keep the value UnwrittenNan().
template <int R, int... kSizes, class Function>
bool Differentiate(const Function& function, double const* const* x, double* r, double** J) {
  constexpr int kBlocks = sizeof...(kSizes);
  constexpr std::array<int, kBlocks> kSize{kSizes...};
  constexpr int kTotal = (kSizes + ...);
  using Jet = BlockJet<kSizes...>;
  std::array<Jet, kTotal> jets;
  std::array<const Jet*, kBlocks> blocks;
  for (int b = 0, k = 0; b < kBlocks; ++b) {
    blocks[b] = jets.data() + k;
    for (int i = 0; i < kSize[b]; ++i, ++k) jets[k] = Jet(x[b][i], k);
  }
  std::array<Jet, R> out;
  out.fill(Jet(UnwrittenNan()));
  if (!function(blocks.data(), out.data())) return false;
  for (int i = 0; i < R; ++i) r[i] = out[i].a;
  for (int b = 0, k = 0; b < kBlocks; k += kSize[b], ++b) {
    if (J[b] == nullptr) continue;
    for (int i = 0; i < R; ++i) std::copy_n(out[i].v.data() + k, kSize[b], J[b] + i * kSize[b]);
  }
  return true;
}

/// Does what Differentiate does if the number and sizes of the blocks are known only at run time.
/// Each pass computes a few derivatives.
template <class Function>
bool DifferentiateDynamic(const Function& function, const std::vector<int>& sizes, int residuals,
                          double const* const* x, double* r, double** J) {
  using Jet = DynamicJet;
  std::vector<std::vector<Jet>> jets;
  std::vector<const Jet*> blocks;
  std::vector<Jet*> wanted;  // coordinates to differentiate by, and the targets of their columns
  std::vector<std::pair<double*, int>> columns;
  for (std::size_t b = 0; b < sizes.size(); ++b) {
    jets.emplace_back(x[b], x[b] + sizes[b]);
    blocks.push_back(jets.back().data());
    for (int i = 0; J[b] != nullptr && i < sizes[b]; ++i) {
      wanted.push_back(jets.back().data() + i);
      columns.emplace_back(J[b] + i, sizes[b]);
    }
  }
  std::size_t first = 0;
  do {
    const std::size_t past = std::min(wanted.size(), first + kDynamicStride);
    for (std::size_t k = first; k < past; ++k) wanted[k]->v[static_cast<int>(k - first)] = 1.0;
    std::vector<Jet> out(static_cast<std::size_t>(residuals), Jet(UnwrittenNan()));
    if (!function(blocks.data(), out.data())) return false;
    for (int i = 0; i < residuals; ++i) {
      const Jet& row = out[static_cast<std::size_t>(i)];
      r[i] = row.a;
      for (std::size_t k = first; k < past; ++k) {
        columns[k].first[i * columns[k].second] = row.v[static_cast<int>(k - first)];
      }
    }
    for (std::size_t k = first; k < past; ++k) wanted[k]->v.setZero();
    first = past;
  } while (first < wanted.size());
  return true;
}

}  // namespace dn
