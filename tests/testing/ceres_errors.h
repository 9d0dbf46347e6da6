#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dn::testing {

/// Reprojection error of a pinhole camera with focal length and two terms of radial distortion:
/// rotation vector, translation, f, k1, k2.
struct Reprojection {
  double u, v;
  template <class T>
  bool operator()(const T* camera, const T* point, T* r) const {
    T p[3];
    ceres::AngleAxisRotatePoint(camera, point, p);
    for (int i = 0; i < 3; ++i) p[i] += camera[3 + i];
    const T x = -p[0] / p[2], y = -p[1] / p[2];
    const T n = x * x + y * y;
    const T size = camera[6] * (T(1.0) + n * (camera[7] + n * camera[8]));
    r[0] = size * x - u;
    r[1] = size * y - v;
    return true;
  }
};

/// Error of a relative pose of a g2o file, with the square root L^T of its information matrix. It
/// is the translation, then twice the vector part of the quaternion.
struct RelativePoseError {
  Eigen::Vector3d p;
  Eigen::Quaterniond q;
  Eigen::Matrix<double, 6, 6> sqrt_information;
  template <class T>
  bool operator()(const T* p_a, const T* q_a, const T* p_b, const T* q_b, T* r) const {
    using V = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const V> pa(p_a), pb(p_b);
    const Eigen::Map<const Eigen::Quaternion<T>> qa(q_a), qb(q_b);
    const Eigen::Quaternion<T> difference = q.cast<T>() * (qa.conjugate() * qb).conjugate();
    Eigen::Matrix<T, 6, 1> e;
    e << qa.conjugate() * V(pb - pa) - p.cast<T>(), T(2.0) * difference.vec();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> out(r);
    out = sqrt_information.cast<T>() * e;
    return true;
  }
};

}  // namespace dn::testing
