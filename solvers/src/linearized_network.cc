#include <dn/error.h>
#include <dn/parallel.h>
#include <dn/solvers/linearized_network.h>

#include <string>

#include "normal_equations.h"

namespace dn {
namespace {

void ExpectRows(Eigen::Index rows, Eigen::Index expected, const char* what) {
  if (rows == expected) return;
  throw InvalidInput("linearised network: " + std::to_string(rows) + " rows for " +
                     std::to_string(expected) + " " + what);
}

}  // namespace

struct LinearizedNetwork::Impl {
  Impl(const Network& network, int threads)
      : layout(network), linearization(network, layout, threads) {}

  UnknownLayout layout;
  Linearization linearization;
};

LinearizedNetwork::LinearizedNetwork(const Network& network, int threads)
    : impl_(std::make_unique<Impl>(network, threads)), threads_(threads) {
  for (const Linearization::Edge& edge : impl_->linearization.edges()) {
    factors_.push_back({edge.factor, edge.first_row, edge.rows});
  }
}

LinearizedNetwork::~LinearizedNetwork() = default;
LinearizedNetwork::LinearizedNetwork(LinearizedNetwork&&) noexcept = default;
LinearizedNetwork& LinearizedNetwork::operator=(LinearizedNetwork&&) noexcept = default;

int LinearizedNetwork::parameters() const { return impl_->layout.size(); }

int LinearizedNetwork::FirstColumn(BlockId block) const {
  const int position = impl_->layout.position_of.at(static_cast<std::size_t>(block));
  return position < 0 ? -1 : impl_->layout.offset[static_cast<std::size_t>(position)];
}

const Eigen::VectorXd& LinearizedNetwork::residual() const {
  return impl_->linearization.residual();
}

Eigen::MatrixXd LinearizedNetwork::Times(const Eigen::MatrixXd& X) const {
  ExpectRows(X.rows(), parameters(), "unknowns");
  const Linearization& linearization = impl_->linearization;
  const UnknownLayout& layout = impl_->layout;
  Eigen::MatrixXd E = Eigen::MatrixXd::Zero(rows(), X.cols());
  ParallelFor(static_cast<int>(linearization.edges().size()), threads_, [&](int e) {
    const Linearization::Edge& edge = linearization.edges()[static_cast<std::size_t>(e)];
    const auto J = linearization.jacobian(edge);
    int column = 0;
    for (int b = 0; b < edge.num_blocks; ++b) {
      const int p = linearization.positions(edge)[b];
      const int size = layout.size_of(p);
      E.middleRows(edge.first_row, edge.rows).noalias() +=
          J.middleCols(column, size) *
          X.middleRows(layout.offset[static_cast<std::size_t>(p)], size);
      column += size;
    }
  });
  return E;
}

Eigen::MatrixXd LinearizedNetwork::TransposeTimes(const Eigen::MatrixXd& E) const {
  ExpectRows(E.rows(), rows(), "residuals");
  const Linearization& linearization = impl_->linearization;
  const UnknownLayout& layout = impl_->layout;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(parameters(), E.cols());
  for (const Linearization::Edge& edge : linearization.edges()) {
    const auto J = linearization.jacobian(edge);
    int column = 0;
    for (int b = 0; b < edge.num_blocks; ++b) {
      const int p = linearization.positions(edge)[b];
      const int size = layout.size_of(p);
      G.middleRows(layout.offset[static_cast<std::size_t>(p)], size).noalias() +=
          J.middleCols(column, size).transpose() * E.middleRows(edge.first_row, edge.rows);
      column += size;
    }
  }
  return G;
}

Eigen::MatrixXd LinearizedNetwork::Project(const Eigen::MatrixXd& E,
                                           const Marginals& marginals) const {
  return E - Times(marginals.Solve(TransposeTimes(E)));
}

}  // namespace dn
