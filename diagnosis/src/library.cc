#include "library.h"

#include <dn/adjustment/candidate_effects.h>
#include <dn/adjustment/laser_departures.h>
#include <dn/effects/effect_table.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "generic_effects.h"

namespace dn::internal {
namespace {

constexpr double kShortestPeriodS = 30.0;
constexpr int kMostGnssCosines = 60, kMostBiasCosines = 24;
constexpr double kNetworkTausS[] = {10.0, 40.0, 160.0, 640.0};

Candidate Physical(EffectId id, std::size_t block) {
  const EffectSpec& spec = EffectRow(id);
  Candidate candidate;
  candidate.name = spec.name;
  candidate.id = id;
  candidate.block = block;
  candidate.unit = spec.components[0].unit;
  candidate.per_si = 1.0 / spec.components[0].to_si;
  const Eigen::VectorXd typical = TypicalInSi(spec);
  candidate.typical = typical.head(typical.size() - (spec.process() ? 1 : 0));
  return candidate;
}

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
    std::vector<UserEffect> own;
    for (const Shape& shape : shapes_) own.push_back(shape.effect);
    std::vector<CandidateEffect> found = CandidateEffects(network_, options_.threads, own);
    const auto first_own = found.end() - static_cast<std::ptrdiff_t>(own.size());
    for (auto at = found.begin(); at != first_own; ++at) AddFixed(std::move(*at));
    for (std::size_t k = 0; k < shapes_.size(); ++k) {
      CandidateEffect& shape = *(first_own + static_cast<std::ptrdiff_t>(k));
      if (!shape.model.empty()) (this->*shapes_[k].add)(std::move(shape));
    }
    AddBiasProcesses(EffectId::kGyroBiasProcess, "gyro bias oscillation",
                     network_.trajectory().gyro_bias());
    AddBiasProcesses(EffectId::kAccelBiasProcess, "accel bias oscillation",
                     network_.trajectory().accel_bias());
    return std::move(library_);
  }

 private:
  /// Columns of an unmodelled discrepancy, and the function that makes candidates from them.
  struct Shape {
    UserEffect effect;
    void (LibraryMaker::*add)(CandidateEffect shape);
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
    shapes_.push_back({LaserByScanAngle(network_), &LibraryMaker::AddGeneric});
    shapes_.push_back({LaserByStrip(strips_), &LibraryMaker::AddGeneric});
  }

  std::vector<MapPose> Path() const {
    std::vector<MapPose> path;
    for (std::size_t k = 0; k < network_.trajectory().node_times().size(); ++k) {
      path.push_back(network_.trajectory().NodePose(k));
    }
    return path;
  }

  std::size_t AddBlock(EffectModel model) {
    library_.blocks.push_back(std::move(model));
    return library_.blocks.size() - 1;
  }

  void AddFixed(CandidateEffect effect) {
    const EffectId id = FindEffect(effect.name)->id;
    // Steps of the boresight are made elsewhere, from its cells.
    if (!options_.Wanted(id) || id == EffectId::kBoresightStep) return;
    Candidate candidate = Physical(id, AddBlock(std::move(effect.model)));
    candidate.times = effect.times;
    library_.candidates.push_back(std::move(candidate));
  }

  void AddGeneric(CandidateEffect shape) {
    const std::size_t block = AddBlock(std::move(shape.model));
    AddGeneric(shape, block);
  }

  void AddGeneric(const CandidateEffect& shape, std::size_t block) {
    library_.candidates.push_back(MakeDiscrepancy(shape.name, block, shape.typical));
  }

  void AddGnssCells(CandidateEffect shape) {
    const std::size_t block = AddBlock(std::move(shape.model));
    AddGnssSteps(block);
    AddGeneric(shape, block);
  }

  void AddGnssCosines(CandidateEffect shape) {
    const std::size_t block = AddBlock(std::move(shape.model));
    AddProcesses(EffectId::kGnssCorrelatedNoise, block, gnss_cosines_);
    AddPeriods("GNSS oscillation", block, gnss_cosines_, shape.typical.head<3>());
  }

  void AddBoresightCells(CandidateEffect shape) {
    const std::size_t block = AddBlock(std::move(shape.model));
    AddBoresightSteps(block);
    AddGeneric(shape, block);
  }

  void AddBoresightSettling(CandidateEffect shape) {
    const std::size_t block = AddBlock(std::move(shape.model));
    AddSettling(shape.name, block, SettlingTausS(strips_), shape.typical, &library_);
  }

  void AddGnssSteps(std::size_t block) {
    if (!options_.Wanted(EffectId::kGnssPositionStep)) return;
    const int n = gnss_cells_.count();
    for (int first = 0; first < n; ++first) {
      for (int past = first + 1; past <= n; ++past) {
        if (past - first == n) continue;  // a shift of the whole flight changes only the datum
        Candidate step = Physical(EffectId::kGnssPositionStep, block);
        step.cells = CellRange{first, past};
        const double end_s =
            past < n ? gnss_cells_.start_s[static_cast<std::size_t>(past)] : begin_s_ + length_s_;
        step.times.window_s = {{gnss_cells_.start_s[static_cast<std::size_t>(first)], end_s}};
        library_.candidates.push_back(std::move(step));
      }
    }
  }

  void AddBoresightSteps(std::size_t block) {
    if (!options_.Wanted(EffectId::kBoresightStep)) return;
    for (int cell = 1; cell < boresight_cells_.count(); ++cell) {
      Candidate step = Physical(EffectId::kBoresightStep, block);
      step.cells = CellRange{cell, boresight_cells_.count()};
      step.times.t0_s = boresight_cells_.start_s[static_cast<std::size_t>(cell)];
      library_.candidates.push_back(std::move(step));
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
      Candidate process = Physical(id, block);
      const Eigen::Vector3d axes = Axes(EffectRow(id));
      const Eigen::VectorXd of_cosine = cosines.GaussMarkov(tau_s);
      process.typical.resize(3 * of_cosine.size());
      for (Eigen::Index k = 0; k < of_cosine.size(); ++k) {
        process.typical.segment<3>(3 * k) = of_cosine[k] * axes;
      }
      process.tau_s = tau_s;
      library_.candidates.push_back(std::move(process));
    }
  }

  /// Adds oscillations. The power of an oscillation lies in two neighbouring cosines, while that of
  /// a process is spread.
  void AddPeriods(const std::string& words, std::size_t block, const Cosines& cosines,
                  const Eigen::Vector3d& axes) {
    for (int k = 1; k + 1 < cosines.count; ++k) {
      Candidate wave = MakeDiscrepancy(words, block, axes.replicate<2, 1>());
      wave.cells = CellRange{k, k + 2, 3, false};
      wave.period_s = 2.0 / (cosines.FrequencyHz(k) + cosines.FrequencyHz(k + 1));
      library_.candidates.push_back(std::move(wave));
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
    const std::size_t block = AddBlock(std::move(model));
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

/// Returns the rows of X that belong to a candidate.
Eigen::MatrixXd CandidateRows(const Candidate& candidate, const JointScore& score,
                              const Eigen::Ref<const Eigen::MatrixXd>& X) {
  const Eigen::Index first = score.first[candidate.block];
  const auto of_block = X.middleRows(first, score.first[candidate.block + 1] - first);
  return candidate.cells ? candidate.cells->Rows(of_block) : Eigen::MatrixXd(of_block);
}

}  // namespace

bool LibraryOptions::Wanted(const std::string& effect) const {
  const auto holds = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), effect) != names.end();
  };
  return !holds(left_out) && (effects.empty() || holds(effects));
}

Library MakeLibrary(const FlightNetwork& network, const LinearizedNetwork& linearized,
                    const LibraryOptions& options) {
  return LibraryMaker(network, linearized, options).Run();
}

Candidate MakeDiscrepancy(const std::string& name, std::size_t block,
                          const Eigen::VectorXd& typical) {
  Candidate candidate;
  candidate.name = name;
  candidate.block = block;
  candidate.typical = typical;
  candidate.unit = "1";
  return candidate;
}

void AddSettling(const std::string& name, std::size_t block, const std::vector<double>& taus_s,
                 const Eigen::VectorXd& typical, Library* library) {
  for (int k = 0; k < static_cast<int>(taus_s.size()); ++k) {
    Candidate settling = MakeDiscrepancy(name, block, typical.segment<3>(3 * k));
    settling.cells = CellRange{k, k + 1};
    settling.decay_s = taus_s[static_cast<std::size_t>(k)];
    library->candidates.push_back(std::move(settling));
  }
}

Eigen::MatrixXd CellRange::Rows(const Eigen::Ref<const Eigen::MatrixXd>& X) const {
  if (!in_common) return X.middleRows(width * first, width * (past - first));
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(width, X.cols());
  for (Eigen::Index column = 0; column < X.cols(); ++column) {
    const double* const x = X.col(column).data();
    for (int k = first; k < past; ++k) {
      for (int r = 0; r < width; ++r) sum(r, column) += x[width * k + r];
    }
  }
  return sum;
}

EffectModel CandidateModel(const Candidate& candidate, const Library& library) {
  EffectModel model = library.blocks[candidate.block];
  if (!candidate.cells) return model;
  for (EffectPart& part : model) part.L = candidate.cells->Rows(part.L.transpose()).transpose();
  return model;
}

Eigen::VectorXd CandidateScore(const Candidate& candidate, const JointScore& score,
                               const Eigen::VectorXd& s) {
  return CandidateRows(candidate, score, s);
}

Eigen::MatrixXd CandidateInformation(const Candidate& candidate, const JointScore& score) {
  return CandidateInformation(candidate, candidate, score);
}

Eigen::MatrixXd CandidateInformation(const Candidate& a, const Candidate& b,
                                     const JointScore& score) {
  // Only few columns of a are needed for a range of cells, so they are selected first.
  const Eigen::Index first = score.first[a.block];
  if (!a.cells) {
    return CandidateRows(b, score, score.A.middleCols(first, score.first[a.block + 1] - first))
        .transpose();
  }
  CellRange cells = *a.cells;
  const Eigen::Index begin = first + cells.width * cells.first;
  cells.past -= cells.first;
  cells.first = 0;
  return cells.Rows(
      CandidateRows(b, score, score.A.middleCols(begin, cells.width * cells.past)).transpose());
}

Eigen::VectorXd CandidateSignature(const Candidate& candidate, const JointScore& score) {
  return CandidateRows(candidate, score, score.signature2);
}

Eigen::MatrixXd CandidateShift(const Candidate& candidate, const JointScore& score) {
  return CandidateRows(candidate, score, score.shift.transpose()).transpose();
}

}  // namespace dn::internal
