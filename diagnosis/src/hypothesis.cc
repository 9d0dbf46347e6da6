#include "hypothesis.h"

#include <dn/files/scanners.h>

#include <utility>

namespace dn::diagnosis_internal {
namespace {

/// Returns the rows of X that belong to a hypothesis.
Eigen::MatrixXd SelectRows(const Hypothesis& hypothesis, const JointScore& score,
                           const Eigen::Ref<const Eigen::MatrixXd>& X) {
  const Eigen::Index first = score.first[hypothesis.block];
  const auto of_block = X.middleRows(first, score.first[hypothesis.block + 1] - first);
  return hypothesis.cells ? hypothesis.cells->Rows(of_block) : Eigen::MatrixXd(of_block);
}

}  // namespace

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

Hypothesis MakeHypothesis(EffectId id, std::size_t block) {
  const EffectSpec& spec = EffectRow(id);
  Hypothesis hypothesis;
  hypothesis.name = spec.name;
  hypothesis.id = id;
  hypothesis.block = block;
  hypothesis.unit = spec.components[0].unit;
  hypothesis.per_si = 1.0 / spec.components[0].to_si;
  const Eigen::VectorXd typical = TypicalInSi(spec);
  hypothesis.typical = typical.head(typical.size() - (spec.process() ? 1 : 0));
  return hypothesis;
}

Hypothesis MakeHypothesis(const EstimableEffect& effect, const EffectSite& site) {
  Hypothesis hypothesis = MakeHypothesis(effect.id);
  if (EffectRow(effect.id).sensor == EffectSensor::kLidar) {
    hypothesis.name = ScannerName(site.flight.config, hypothesis.name, site.scanner);
  }
  hypothesis.remedy = effect.remedy;
  hypothesis.times = site.times;
  hypothesis.action = MakeAction(effect, site);
  return hypothesis;
}

Hypothesis MakeDiscrepancy(const std::string& name, EffectAction action, Eigen::Index components,
                           double typical) {
  Hypothesis hypothesis;
  hypothesis.name = name;
  hypothesis.action = std::move(action);
  hypothesis.typical = Eigen::VectorXd::Constant(components, typical);
  return hypothesis;
}

Hypothesis MakeDiscrepancy(const std::string& name, std::size_t block, const CellRange& cells,
                           const Eigen::VectorXd& typical) {
  Hypothesis hypothesis;
  hypothesis.name = name;
  hypothesis.block = block;
  hypothesis.cells = cells;
  hypothesis.typical = typical;
  return hypothesis;
}

std::size_t Library::AddBlock(EffectModel columns) {
  blocks.push_back(std::move(columns));
  return blocks.size() - 1;
}

void Library::Add(Hypothesis hypothesis, EffectModel columns) {
  hypothesis.block = AddBlock(std::move(columns));
  hypotheses.push_back(std::move(hypothesis));
}

EffectModel SelectColumns(const Hypothesis& hypothesis, const Library& library) {
  EffectModel columns = library.blocks[hypothesis.block];
  if (!hypothesis.cells) return columns;
  for (EffectPart& part : columns) part.L = hypothesis.cells->Rows(part.L.transpose()).transpose();
  return columns;
}

Eigen::VectorXd SelectScore(const Hypothesis& hypothesis, const JointScore& score,
                            const Eigen::VectorXd& s) {
  return SelectRows(hypothesis, score, s);
}

Eigen::MatrixXd SelectInformation(const Hypothesis& hypothesis, const JointScore& score) {
  return SelectInformation(hypothesis, hypothesis, score);
}

Eigen::MatrixXd SelectInformation(const Hypothesis& a, const Hypothesis& b,
                                  const JointScore& score) {
  // Only few columns of a are needed for a range of cells, so they are selected first.
  const Eigen::Index first = score.first[a.block];
  if (!a.cells) {
    return SelectRows(b, score, score.A.middleCols(first, score.first[a.block + 1] - first))
        .transpose();
  }
  CellRange cells = *a.cells;
  const Eigen::Index begin = first + cells.width * cells.first;
  cells.past -= cells.first;
  cells.first = 0;
  return cells.Rows(
      SelectRows(b, score, score.A.middleCols(begin, cells.width * cells.past)).transpose());
}

Eigen::VectorXd SelectSignature(const Hypothesis& hypothesis, const JointScore& score) {
  return SelectRows(hypothesis, score, score.signature2);
}

Eigen::MatrixXd SelectShift(const Hypothesis& hypothesis, const JointScore& score) {
  return SelectRows(hypothesis, score, score.shift.transpose()).transpose();
}

}  // namespace dn::diagnosis_internal
