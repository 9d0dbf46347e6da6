#include "point_tree.h"

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace dn::matching_internal {
namespace {

using Eigen::Vector3d;
using Tree = flann::KDTreeSingleIndex<flann::L2_Simple<float>>;

constexpr int kLeafPoints = 15;

class NearestOne final : public flann::ResultSet<float> {
 public:
  bool full() const override { return true; }
  void addPoint(float squared_m2, std::size_t index) override {
    if (squared_m2 >= squared_m2_) return;
    squared_m2_ = squared_m2;
    index_ = index;
  }
  float worstDist() const override { return squared_m2_; }

  PointTree::Nearest nearest() const {
    return {index_, std::sqrt(static_cast<double>(squared_m2_))};
  }

 private:
  float squared_m2_ = std::numeric_limits<float>::infinity();
  std::size_t index_ = 0;
};

class AllWithin final : public flann::ResultSet<float> {
 public:
  AllWithin(float radius2_m2, std::vector<std::size_t>* found)
      : radius2_m2_(radius2_m2), found_(*found) {}
  bool full() const override { return true; }
  void addPoint(float squared_m2, std::size_t index) override {
    if (squared_m2 < radius2_m2_) found_.push_back(index);
  }
  float worstDist() const override { return radius2_m2_; }

 private:
  float radius2_m2_;
  std::vector<std::size_t>& found_;
};

/// The nearest points within a radius, sorted by distance.
class SomeNearest final : public flann::ResultSet<float> {
 public:
  SomeNearest(std::size_t count, float radius2_m2) : count_(count), radius2_m2_(radius2_m2) {
    entries_.reserve(count + 1);
  }
  bool full() const override { return entries_.size() == count_; }
  void addPoint(float squared_m2, std::size_t index) override {
    if (squared_m2 >= worstDist()) return;
    const Entry entry{squared_m2, index};
    entries_.insert(std::upper_bound(entries_.begin(), entries_.end(), entry), entry);
    if (entries_.size() > count_) entries_.pop_back();
  }
  float worstDist() const override { return full() ? entries_.back().first : radius2_m2_; }

  void CopyTo(std::vector<std::size_t>* found) const {
    for (const Entry& entry : entries_) found->push_back(entry.second);
  }

 private:
  using Entry = std::pair<float, std::size_t>;
  std::size_t count_;
  float radius2_m2_;
  std::vector<Entry> entries_;
};

}  // namespace

struct PointTree::Index {
  explicit Index(const std::vector<Vector3d>& points_m)
      : origin_m(points_m.front()), tree(flann::KDTreeSingleIndexParams(kLeafPoints)) {
    coordinates.reserve(3 * points_m.size());
    for (const Vector3d& p_m : points_m) {
      for (const float value : Local(p_m)) coordinates.push_back(value);
    }
    tree.buildIndex(flann::Matrix<float>(coordinates.data(), points_m.size(), 3));
  }

  std::array<float, 3> Local(const Vector3d& p_m) const {
    const Eigen::Vector3f p = (p_m - origin_m).cast<float>();
    return {p.x(), p.y(), p.z()};
  }

  void Ask(const Vector3d& p_m, flann::ResultSet<float>* result) const {
    tree.findNeighbors(*result, Local(p_m).data(), flann::SearchParams());
  }

  Vector3d origin_m;
  std::vector<float> coordinates;
  Tree tree;
};

PointTree::PointTree(const std::vector<Vector3d>& points_m)
    : index_(std::make_unique<const Index>(points_m)) {}

PointTree::~PointTree() = default;
PointTree::PointTree(PointTree&&) noexcept = default;

PointTree::Nearest PointTree::NearestTo(const Vector3d& p_m) const {
  NearestOne result;
  index_->Ask(p_m, &result);
  return result.nearest();
}

void PointTree::FindWithin(const Vector3d& p_m, double radius_m,
                           std::vector<std::size_t>* found) const {
  found->clear();
  AllWithin result(static_cast<float>(radius_m * radius_m), found);
  index_->Ask(p_m, &result);
}

void PointTree::FindNearest(const Vector3d& p_m, std::size_t count, double radius_m,
                            std::vector<std::size_t>* found) const {
  found->clear();
  SomeNearest result(count, static_cast<float>(radius_m * radius_m));
  index_->Ask(p_m, &result);
  result.CopyTo(found);
}

}  // namespace dn::matching_internal
