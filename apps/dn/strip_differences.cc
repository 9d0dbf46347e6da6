#include "strip_differences.h"

#include <dn/adjustment/swath_separation.h>
#include <dn/median.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

namespace dn::apps {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kFewestCells = 10;
constexpr std::size_t kMostSampled = 500;
constexpr double kMostNodes = 4e6;  // of a raster; larger ones get larger cells
constexpr const char* kNoData = "-9999";

struct Statistics {
  std::size_t cells = 0;
  double median_m = 0.0, rms_m = 0.0;
  SwathSeparation separation{};
};

Statistics Summarise(const std::vector<SurfaceDifference>& differences) {
  Statistics all;
  all.cells = differences.size();
  std::vector<double> up_m;
  double squares_m2 = 0.0;
  for (const SurfaceDifference& one : differences) {
    all.separation.Add(one.up_m);
    up_m.push_back(one.up_m);
    squares_m2 += one.up_m * one.up_m;
  }
  if (up_m.empty()) return all;
  all.rms_m = std::sqrt(squares_m2 / static_cast<double>(up_m.size()));
  all.median_m = Median(std::move(up_m));
  return all;
}

Json StatisticsJson(const Statistics& all) {
  if (all.cells == 0) return nullptr;
  return {{"cells", all.cells},
          {"median_m", all.median_m},
          {"rms_m", all.rms_m},
          {"separation", all.separation.ToJson()}};
}

/// Differences as a surface, to look them up by position.
FlatSurface AsSurface(const std::vector<SurfaceDifference>& differences, double cell_m) {
  FlatSurface surface{cell_m, {}};
  for (const SurfaceDifference& one : differences) surface.up_m.emplace(one.cell, one.up_m);
  return surface;
}

/// Returns a sample of the cells that are flat before and after: centres in the mapping frame, and
/// their differences.
Json SampleJson(const std::vector<SurfaceDifference>& before,
                const std::vector<SurfaceDifference>& after, double cell_m) {
  const FlatSurface old_ones = AsSurface(before, cell_m);
  std::vector<SurfaceDifference> in_both;
  std::ranges::copy_if(after, std::back_inserter(in_both), [&](const SurfaceDifference& one) {
    return old_ones.up_m.contains(one.cell);
  });
  Json sample{{"east_m", Json::array()},
              {"north_m", Json::array()},
              {"before_m", Json::array()},
              {"after_m", Json::array()}};
  for (std::size_t k = 0; k < in_both.size(); k += in_both.size() / kMostSampled + 1) {
    const Vector2d centre_m = CellCentre(in_both[k].cell, cell_m);
    sample["east_m"].push_back(centre_m.x());
    sample["north_m"].push_back(centre_m.y());
    sample["before_m"].push_back(old_ones.up_m.at(in_both[k].cell));
    sample["after_m"].push_back(in_both[k].up_m);
  }
  return sample;
}

/// A raster in the system of the points. ecef has no plane: its rasters are in the mapping frame.
class DifferenceRaster {
 public:
  DifferenceRaster(const FlatSurface& differences, double height_m, const PointCrs& crs)
      : differences_(differences), crs_(crs) {
    const Vector2d any_m = CellCentre(differences.up_m.begin()->first, differences.cell_m);
    Vector3d p_m(any_m.x(), any_m.y(), height_m);
    height_c_ = Convert(p_m).z();
    low_ = high_ = Convert(p_m).head<2>();
    for (const auto& [key, up_m] : differences.up_m) {
      p_m.head<2>() = CellCentre(key, differences.cell_m);
      const Vector2d p_c = Convert(p_m).head<2>();
      low_ = low_.cwiseMin(p_c);
      high_ = high_.cwiseMax(p_c);
    }
    const double unit = (Convert(p_m + Vector3d::UnitX()) - Convert(p_m)).head<2>().norm();
    cell_ = differences.cell_m * unit;
    cell_ *= std::max(1.0, std::sqrt(Nodes(0) * Nodes(1) / kMostNodes));
  }

  /// Returns the text of an ASCII grid of Esri.
  std::string Text() const {
    const auto columns = static_cast<long>(Nodes(0)), rows = static_cast<long>(Nodes(1));
    std::string text = fmt::format(
        "ncols {}\nnrows {}\nxllcenter {:.3f}\nyllcenter {:.3f}\ncellsize {:.6f}\n"
        "NODATA_value {}\n",
        columns, rows, low_.x(), low_.y(), cell_, kNoData);
    for (long row = rows - 1; row >= 0; --row) {
      for (long column = 0; column < columns; ++column) {
        const auto up_m = At(low_ + cell_ * Vector2d(column, row));
        if (column > 0) text += ' ';
        if (up_m) {
          fmt::format_to(std::back_inserter(text), "{:.4f}", *up_m);
        } else {
          text += kNoData;
        }
      }
      text += '\n';
    }
    return text;
  }

 private:
  double Nodes(int axis) const { return std::floor((high_[axis] - low_[axis]) / cell_ + 1.5); }

  bool IsPlane() const { return crs_.name() != "ecef"; }

  Vector3d Convert(const Vector3d& p_m) const { return IsPlane() ? crs_.FromMap(p_m) : p_m; }

  std::optional<double> At(const Vector2d& p_c) const {
    const Vector3d p(p_c.x(), p_c.y(), height_c_);
    return differences_.At(Vector3d(IsPlane() ? crs_.ToMap(p) : p).head<2>());
  }

  const FlatSurface& differences_;
  const PointCrs& crs_;
  double height_c_ = 0.0, cell_ = 1.0;
  Vector2d low_, high_;
};

double MeanHeight(const FlatSurface& surface) {
  double sum_m = 0.0;
  for (const auto& [key, up_m] : surface.up_m) sum_m += up_m;
  return sum_m / static_cast<double>(surface.up_m.size());
}

void PrintPair(const std::string& name, const Statistics& before, const Statistics& after) {
  const auto text = [](const Statistics& all) {
    if (all.cells == 0) return fmt::format("{:>9} {:>8} {:>8}", "", "", "");
    const double to_8_cm = all.separation.ToJson()["to_8_cm"].get<double>();
    return fmt::format("{:>9.4f} {:>8.4f} {:>7.1f}%", all.median_m, all.rms_m, 100.0 * to_8_cm);
  };
  fmt::print("  {:<24} {:>8}  {}  {}\n", name, after.cells, text(before), text(after));
}

void PrintHeader(double cell_m) {
  fmt::print("height differences of strips on flat ground, cells of {:g} m\n", cell_m);
  fmt::print("  {:<24} {:>8}  {:>9} {:>8} {:>8}  {:>9} {:>8} {:>8}\n", "strips", "cells",
             "median[m]", "rms [m]", "to 8 cm", "new [m]", "rms [m]", "to 8 cm");
}

/// Prints and stages the differences `after` of two strips; returns their entry for georef.json.
Json ReportPair(const StripSurfaces& first, const StripSurfaces& second,
                const std::vector<SurfaceDifference>& after, const PointCrs& crs, Run* run) {
  const double cell_m = first.after.cell_m;
  const std::string name = first.strip + "-" + second.strip;
  const auto before = SurfaceDifferences(first.before, second.before);
  const Statistics old_ones = Summarise(before), new_ones = Summarise(after);
  PrintPair(name, old_ones, new_ones);
  const std::string file = "differences/" + name + ".asc";
  if (const auto prj = PrjText(crs.name())) run->AddFile("differences/" + name + ".prj", *prj);
  const FlatSurface surface = AsSurface(after, cell_m);
  run->AddFile(file, DifferenceRaster(surface, MeanHeight(first.after), crs).Text());
  return {{"strips", {first.strip, second.strip}},       {"cell_m", cell_m},
          {"before", StatisticsJson(old_ones)},          {"after", StatisticsJson(new_ones)},
          {"sample", SampleJson(before, after, cell_m)}, {"raster", file}};
}

}  // namespace

Json CompareStrips(const std::vector<StripSurfaces>& strips, const PointCrs& crs, Run* run) {
  Json list = Json::array();
  for (std::size_t i = 0; i < strips.size(); ++i) {
    for (std::size_t j = i + 1; j < strips.size(); ++j) {
      const auto after = SurfaceDifferences(strips[i].after, strips[j].after);
      if (after.size() < kFewestCells) continue;
      if (list.empty()) PrintHeader(strips[i].after.cell_m);
      list.push_back(ReportPair(strips[i], strips[j], after, crs, run));
    }
  }
  return list;
}

}  // namespace dn::apps
