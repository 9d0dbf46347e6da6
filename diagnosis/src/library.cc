#include "library.h"

#include <dn/effects/effect_table.h>
#include <dn/names.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "discrepancies.h"
#include "network_hypotheses.h"

namespace dn::diagnosis_internal {
namespace {

constexpr double kShortestPeriodS = 30.0;
constexpr int kMostGnssCosines = 60, kMostBiasCosines = 24;
constexpr double kNetworkTausS[] = {10.0, 40.0, 160.0, 640.0};

class LibraryMaker {
 public:
  LibraryMaker(const FlightNetwork& network, const LinearizedNetwork& linearized,
               const LibraryOptions& options)
      : network_(network), linearized_(linearized), options_(options) {
    begin_s_ = network.trajectory().node_times().front();
    length_s_ = network.trajectory().node_times().back() - begin_s_;
    for (const PairEdge& edge : network.pairs().edges()) {
      with_pairs_ = with_pairs_ || network.net().factor(edge.id).active;
    }
    if (with_pairs_) strips_ = InTime(FindStrips(network_.flight()));
  }

  Library Run() {
    ListShapes();
    std::vector<Hypothesis> discrepancies;
    for (const Shape& shape : shapes_) discrepancies.push_back(shape.discrepancy);
    Library found = MakeNetworkHypotheses(network_, options_.threads, discrepancies);
    const std::size_t first_shape = found.hypotheses.size() - shapes_.size();
    for (std::size_t k = 0; k < found.hypotheses.size(); ++k) {
      Hypothesis& hypothesis = found.hypotheses[k];
      EffectModel& columns = found.blocks[k];
      if (k < first_shape) {
        AddFixed(std::move(hypothesis), std::move(columns));
      } else if (!columns.empty()) {
        (this->*shapes_[k - first_shape].add)(std::move(hypothesis), std::move(columns));
      }
    }
    AddBiasProcesses(EffectId::kGyroBiasProcess, "gyro bias oscillation",
                     network_.trajectory().gyro_bias());
    AddBiasProcesses(EffectId::kAccelBiasProcess, "accel bias oscillation",
                     network_.trajectory().accel_bias());
    return std::move(library_);
  }

 private:
  /// An unmodelled discrepancy, and the function that makes hypotheses from its columns.
  struct Shape {
    Hypothesis discrepancy;
    void (LibraryMaker::*add)(Hypothesis shape, EffectModel columns);
  };

  void ListShapes() {
    gnss_cosines_.begin_s = bias_cosines_.begin_s = begin_s_;
    gnss_cosines_.length_s = bias_cosines_.length_s = length_s_;
    gnss_cells_ = GnssCells(begin_s_, length_s_);
    const int waves = std::max(2, static_cast<int>(2.0 * length_s_ / kShortestPeriodS));
    gnss_cosines_.count = std::min(waves, kMostGnssCosines);
    bias_cosines_.count = std::min(waves, kMostBiasCosines);
    shapes_ = {{GnssByCell(gnss_cells_), &LibraryMaker::AddGnssCells},
               {GnssByCosine(gnss_cosines_), &LibraryMaker::AddGnssCosines}};
    if (options_.Wanted(EffectId::kGnssMultipath)) {
      shapes_.push_back(
          {GnssByBankAndCosine(gnss_cosines_, network_.trajectory(), network_.flight().frame),
           &LibraryMaker::AddGnssMultipath});
    }
    if (with_pairs_) ListPairShapes();
  }

  void ListPairShapes() {
    boresight_cells_ = BoresightCells(strips_);
    shapes_.push_back({BoresightByCell(boresight_cells_), &LibraryMaker::AddBoresightCells});
    shapes_.push_back({BoresightSettling(strips_.front().t0_s, SettlingTausS(strips_)),
                       &LibraryMaker::AddBoresightSettling});
    if (strips_.size() >= kFewestHeadings) {
      shapes_.push_back({BoresightByHeading(strips_, Path()), &LibraryMaker::AddGeneric});
    }
    shapes_.push_back({LaserByScanAngle(network_, 0), &LibraryMaker::AddGeneric});
    shapes_.push_back({LaserByStrip(strips_), &LibraryMaker::AddGeneric});
  }

  std::vector<MapPose> Path() const {
    std::vector<MapPose> path;
    for (std::size_t k = 0; k < network_.trajectory().node_times().size(); ++k) {
      path.push_back(network_.trajectory().NodePose(k));
    }
    return path;
  }

  void AddFixed(Hypothesis effect, EffectModel columns) {
    // Steps of the boresight are made elsewhere, from its cells.
    if (!options_.Wanted(*effect.id) || effect.id == EffectId::kBoresightStep) return;
    library_.Add(std::move(effect), std::move(columns));
  }

  void AddGeneric(Hypothesis shape, EffectModel columns) {
    library_.Add(std::move(shape), std::move(columns));
  }

  void AddGnssCells(Hypothesis shape, EffectModel columns) {
    shape.block = library_.AddBlock(std::move(columns));
    AddGnssSteps(shape.block);
    library_.hypotheses.push_back(std::move(shape));
  }

  void AddGnssCosines(Hypothesis shape, EffectModel columns) {
    const std::size_t block = library_.AddBlock(std::move(columns));
    AddProcesses(EffectId::kGnssCorrelatedNoise, block, gnss_cosines_);
    AddPeriods("GNSS oscillation", block, gnss_cosines_, shape.typical.head<3>());
  }

  void AddGnssMultipath(Hypothesis, EffectModel columns) {
    AddProcesses(EffectId::kGnssMultipath, library_.AddBlock(std::move(columns)), gnss_cosines_);
  }

  void AddBoresightCells(Hypothesis shape, EffectModel columns) {
    AddBoresightTimes(std::move(shape), std::move(columns), boresight_cells_, options_, &library_);
  }

  void AddBoresightSettling(Hypothesis shape, EffectModel columns) {
    AddSettling(shape, std::move(columns), SettlingTausS(strips_), &library_);
  }

  void AddGnssSteps(std::size_t block) {
    if (!options_.Wanted(EffectId::kGnssPositionStep)) return;
    const int n = gnss_cells_.count();
    for (int first = 0; first < n; ++first) {
      for (int past = first + 1; past <= n; ++past) {
        if (past - first == n) continue;  // a shift of the whole flight changes only the datum
        Hypothesis step = MakeHypothesis(EffectId::kGnssPositionStep, block);
        step.cells = CellRange{first, past};
        const double end_s =
            past < n ? gnss_cells_.start_s[static_cast<std::size_t>(past)] : begin_s_ + length_s_;
        step.times.window_s = {{gnss_cells_.start_s[static_cast<std::size_t>(first)], end_s}};
        library_.hypotheses.push_back(std::move(step));
      }
    }
  }

  /// Returns the typical sigmas of a process; a single sigma applies to all axes.
  static Eigen::Vector3d Axes(const EffectSpec& process) {
    Eigen::Vector3d axes = Eigen::Vector3d::Constant(process.components[0].typical_si());
    if (process.components.size() < 4) return axes;
    for (std::size_t k = 1; k < 3; ++k) {
      axes[static_cast<Eigen::Index>(k)] = process.components[k].typical_si();
    }
    return axes;
  }

  void AddProcesses(EffectId id, std::size_t block, const Cosines& cosines) {
    if (!options_.Wanted(id)) return;
    for (const double tau_s : kNetworkTausS) {
      if (tau_s > 0.5 * length_s_) continue;
      Hypothesis process = MakeHypothesis(id, block);
      const Eigen::Vector3d axes = Axes(EffectRow(id));
      const Eigen::VectorXd of_cosine = cosines.GaussMarkov(tau_s);
      process.typical.resize(3 * of_cosine.size());
      for (Eigen::Index k = 0; k < of_cosine.size(); ++k) {
        process.typical.segment<3>(3 * k) = of_cosine[k] * axes;
      }
      process.tau_s = tau_s;
      library_.hypotheses.push_back(std::move(process));
    }
  }

  /// Adds oscillations. The power of an oscillation lies in two neighbouring cosines, while that of
  /// a process is spread.
  void AddPeriods(const std::string& words, std::size_t block, const Cosines& cosines,
                  const Eigen::Vector3d& axes) {
    for (int k = 1; k + 1 < cosines.count; ++k) {
      Hypothesis wave =
          MakeDiscrepancy(words, block, CellRange{k, k + 2, 3, false}, axes.replicate<2, 1>());
      wave.period_s = 2.0 / (cosines.FrequencyHz(k) + cosines.FrequencyHz(k + 1));
      library_.hypotheses.push_back(std::move(wave));
    }
  }

  /// Adds the processes of a sensor's error, which acts like its bias.
  void AddBiasProcesses(EffectId id, const std::string& words,
                        const std::vector<ProcessChain>& chains) {
    if (chains.empty()) return;
    const ProcessChain& chain = *std::max_element(
        chains.begin(), chains.end(),
        [](const auto& a, const auto& b) { return a.blocks.size() < b.blocks.size(); });
    EffectModel model;
    for (const InertialEdge& edge : network_.inertial().edges()) {
      const double t_s = network_.trajectory().node_times()[edge.node_i];
      AddBias(edge.id, {{chain.At(t_s).id, t_s}}, &model);
    }
    for (const PairEdge& edge : network_.pairs().edges()) {
      std::map<BlockId, double> blocks;
      for (const std::size_t node : {edge.node_i, edge.node_j}) {
        const double t_s = network_.trajectory().node_times()[node];
        blocks[chain.At(t_s).id] = t_s;
      }
      AddBias(edge.id, blocks, &model);
    }
    const std::size_t block = library_.AddBlock(std::move(model));
    AddProcesses(id, block, bias_cosines_);
    AddPeriods(words, block, bias_cosines_, Axes(EffectRow(id)));
  }

  void AddBias(FactorId id, const std::map<BlockId, double>& blocks, EffectModel* model) const {
    if (!linearized_.FindRows(id)) return;
    const LinearizedNetwork::Factor factor = linearized_.EvaluateFactorAt(id);
    EffectPart part{id, Eigen::MatrixXd::Zero(factor.residual.size(), 3 * bias_cosines_.count)};
    for (const auto& [block, J] : factor.jacobian) {
      const auto at = blocks.find(block);
      if (at == blocks.end()) continue;
      const Eigen::VectorXd weight = bias_cosines_.At(at->second);
      for (int k = 0; k < bias_cosines_.count; ++k) {
        part.L.middleCols<3>(3 * k) += weight[k] * J;
      }
    }
    model->push_back(std::move(part));
  }

  const FlightNetwork& network_;
  const LinearizedNetwork& linearized_;
  const LibraryOptions& options_;
  double begin_s_ = 0.0, length_s_ = 1.0;
  bool with_pairs_ = false;
  std::vector<StripInterval> strips_;
  TimeCells gnss_cells_;
  Cosines gnss_cosines_, bias_cosines_;
  TimeCells boresight_cells_;
  std::vector<Shape> shapes_;
  Library library_;
};

}  // namespace

bool LibraryOptions::Wanted(const std::string& effect) const {
  return !HasName(left_out, effect) && (effects.empty() || HasName(effects, effect));
}

LibraryOptions MakeLibraryOptions(const GapOptions& options) {
  return {options.effects, options.left_out, options.threads};
}

Library MakeLibrary(const FlightNetwork& network, const LinearizedNetwork& linearized,
                    const LibraryOptions& options) {
  return LibraryMaker(network, linearized, options).Run();
}

void AddBoresightTimes(Hypothesis by_cell, EffectModel columns, const TimeCells& cells,
                       const LibraryOptions& options, Library* library) {
  by_cell.block = library->AddBlock(std::move(columns));
  if (options.Wanted(EffectId::kBoresightStep)) {
    for (int cell = 1; cell < cells.count(); ++cell) {
      Hypothesis step = MakeHypothesis(EffectId::kBoresightStep, by_cell.block);
      step.cells = CellRange{cell, cells.count()};
      step.times.t0_s = cells.start_s[static_cast<std::size_t>(cell)];
      library->hypotheses.push_back(std::move(step));
    }
  }
  library->hypotheses.push_back(std::move(by_cell));
}

void AddSettling(const Hypothesis& settling, EffectModel columns, const std::vector<double>& taus_s,
                 Library* library) {
  const std::size_t block = library->AddBlock(std::move(columns));
  for (int k = 0; k < static_cast<int>(taus_s.size()); ++k) {
    Hypothesis one = MakeDiscrepancy(settling.name, block, CellRange{k, k + 1},
                                     settling.typical.segment<3>(3 * k));
    one.decay_s = taus_s[static_cast<std::size_t>(k)];
    library->hypotheses.push_back(std::move(one));
  }
}

}  // namespace dn::diagnosis_internal
