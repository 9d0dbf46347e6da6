#pragma once

#include <dn/network.h>

#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "testing/random.h"

namespace dn::testing {

/// r = diag(1/sigma) [Log(q_ij^-1 q_mi^-1 q_mj); q_mi^-1 (p_mj - p_mi) - p_ij].
struct RelativePose : AutoFactor<RelativePose, 6, Rotation, Vec<3>, Rotation, Vec<3>> {
  Eigen::Quaterniond q_ij;
  Eigen::Vector3d p_ij;
  double sigma_rad, sigma_m;

  template <class T>
  bool Residual(const T* q_mi_data, const T* p_mi_data, const T* q_mj_data, const T* p_mj_data,
                T* r) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q_mi(q_mi_data), q_mj(q_mj_data);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> p_mi(p_mi_data), p_mj(p_mj_data);
    const Eigen::Quaternion<T> q_error = q_ij.conjugate().cast<T>() * (q_mi.conjugate() * q_mj);
    Eigen::Map<Eigen::Matrix<T, 6, 1>> out(r);
    out.template head<3>() = Log(q_error) / T(sigma_rad);
    out.template tail<3>() = (q_mi.conjugate() * (p_mj - p_mi) - p_ij.cast<T>()) / T(sigma_m);
    return true;
  }
};

/// r = (x - z) / sigma, component by component.
template <int N>
struct VectorPrior : AutoFactor<VectorPrior<N>, N, Vec<N>> {
  Eigen::Matrix<double, N, 1> z;
  double sigma = 1.0;

  template <class T>
  bool Residual(const T* x, T* r) const {
    for (int i = 0; i < N; ++i) r[i] = (x[i] - z[i]) / sigma;
    return true;
  }
};

template <int N>
VectorPrior<N> MakeVectorPrior(const Eigen::Matrix<double, N, 1>& z, double sigma) {
  VectorPrior<N> f;
  f.z = z;
  f.sigma = sigma;
  return f;
}

/// r = Log(z^-1 q) / sigma.
template <class Kind>
struct RotationPrior : AutoFactor<RotationPrior<Kind>, 3, Kind> {
  Eigen::Quaterniond z;
  double sigma_rad = 1.0;

  template <class T>
  bool Residual(const T* q_data, T* r) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q(q_data);
    const Eigen::Quaternion<T> q_error = z.conjugate().cast<T>() * q;
    Eigen::Map<Eigen::Matrix<T, 3, 1>> out(r);
    out = Log(q_error) / T(sigma_rad);
    return true;
  }
};

/// r = (p_mb + R_mb R_bs x_s - z_m) / sigma: a known point observed through the boresight.
struct KnownPoint : AutoFactor<KnownPoint, 3, Rotation, Vec<3>, LeftRotation> {
  Eigen::Vector3d x_s, z_m;
  double sigma_m = 1.0;

  template <class T>
  bool Residual(const T* q_mb_data, const T* p_mb_data, const T* q_bs_data, T* r) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q_mb(q_mb_data), q_bs(q_bs_data);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> p_mb(p_mb_data);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> out(r);
    out = (p_mb + q_mb * (q_bs * x_s.cast<T>()) - z_m.cast<T>()) / T(sigma_m);
    return true;
  }
};

/// Options of MakePoseGraph.
struct PoseGraphOptions {
  int nodes = 50;
  int loops = 30;
  double noise = 0.0;  ///< noise of the relative poses, in their sigmas
  bool anchored = true;
};

/// A chain of poses with random loops, one anchor and a boresight that every fifth node observes.
/// The initial values differ from the truth by up to 0.05 rad and 0.5 m.
struct PoseGraph {
  Network network;
  std::vector<Block<Rotation>> q_mb;
  std::vector<Block<Vec<3>>> p_mb;
  Block<LeftRotation> q_bs;
  std::vector<Eigen::Quaterniond> q_mb_true;
  std::vector<Eigen::Vector3d> p_mb_true;
  Eigen::Quaterniond q_bs_true;
  std::vector<FactorId> relative;
};

inline PoseGraph MakePoseGraph(unsigned seed, const PoseGraphOptions& options = {}) {
  std::mt19937 rng(seed);
  PoseGraph graph;
  graph.q_bs_true = Exp(RandomVector(rng, 0.3));
  graph.q_bs = graph.network.AddLeftRotation("boresight", Eigen::Quaterniond::Identity());
  for (int i = 0; i < options.nodes; ++i) {
    const std::string id = std::to_string(i);
    graph.q_mb_true.push_back(RandomRotation(rng));
    graph.p_mb_true.push_back(Eigen::Vector3d(10.0 * i, 0.0, 0.0) + RandomVector(rng, 5.0));
    graph.q_mb.push_back(graph.network.AddRotation(
        "attitude/" + id, graph.q_mb_true.back() * Exp(RandomVector(rng, 0.05))));
    graph.p_mb.push_back(graph.network.AddVector<3>(
        "position/" + id, graph.p_mb_true.back() + RandomVector(rng, 0.5)));
  }

  const auto connect = [&](int i, int j) {
    const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
    RelativePose f;
    f.sigma_rad = 1e-3;
    f.sigma_m = 0.02;
    f.q_ij = graph.q_mb_true[a].conjugate() * graph.q_mb_true[b] *
             Exp(RandomVector(rng, options.noise * f.sigma_rad));
    f.p_ij = graph.q_mb_true[a].conjugate() * (graph.p_mb_true[b] - graph.p_mb_true[a]) +
             RandomVector(rng, options.noise * f.sigma_m);
    graph.relative.push_back(
        graph.network.Add(f, graph.q_mb[a], graph.p_mb[a], graph.q_mb[b], graph.p_mb[b]));
  };
  for (int i = 0; i + 1 < options.nodes; ++i) connect(i, i + 1);
  std::uniform_int_distribution<int> node(0, options.nodes - 1);
  for (int k = 0; k < options.loops; ++k) {
    const int i = node(rng), j = node(rng);
    if (i != j) connect(i, j);
  }
  for (int i = 0; i < options.nodes; i += 5) {
    const auto a = static_cast<std::size_t>(i);
    KnownPoint f;
    f.x_s = RandomVector(rng, 100.0);
    f.z_m = graph.p_mb_true[a] + graph.q_mb_true[a] * (graph.q_bs_true * f.x_s);
    f.sigma_m = 0.05;
    if (options.anchored) graph.network.Add(f, graph.q_mb[a], graph.p_mb[a], graph.q_bs);
  }
  if (options.anchored) {
    RotationPrior<Rotation> attitude;
    attitude.z = graph.q_mb_true[0];
    attitude.sigma_rad = 1e-3;
    graph.network.Add(attitude, graph.q_mb[0]);
    graph.network.Add(MakeVectorPrior<3>(graph.p_mb_true[0], 0.02), graph.p_mb[0]);
  }
  return graph;
}

}  // namespace dn::testing
