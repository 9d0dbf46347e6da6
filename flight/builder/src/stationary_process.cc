#include <dn/builder/stationary_process.h>
#include <dn/error.h>
#include <dn/linear_prior.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <memory>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

namespace dn {
namespace {

constexpr int kAxisCount = 3;

/// Returns M (x) I, which applies M to the states of all axes.
Eigen::MatrixXd OnAllAxes(const Eigen::MatrixXd& M) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(kAxisCount * M.rows(), kAxisCount * M.cols());
  for (Eigen::Index r = 0; r < M.rows(); ++r) {
    for (Eigen::Index c = 0; c < M.cols(); ++c) {
      all.block<kAxisCount, kAxisCount>(kAxisCount * r, kAxisCount * c)
          .diagonal()
          .setConstant(M(r, c));
    }
  }
  return all;
}

/// The blocks of the process and its factors.
class StationaryChain {
 public:
  StationaryChain(const StationaryProcess& process, const ProcessChain& chain, Network* net)
      : process_(process), chain_(chain), net_(*net), n_(process.F.rows()) {
    if (n_ < 1 || process.F.cols() != n_ || process.P.rows() != n_ || process.P.cols() != n_) {
      throw InvalidInput("process of '" + chain.name + "': F is " + Size(process.F) + " and P is " +
                         Size(process.P) + ", must be square and of one size");
    }
  }

  void AddAll() {
    std::vector<BlockId> before = AddStates(0);
    AddFactor(before, Whitening(process_.P, "the covariance P of its states"));
    for (std::size_t k = 1; k < chain_.blocks.size(); ++k) {
      std::vector<BlockId> blocks = before;
      before = AddStates(k);
      blocks.insert(blocks.end(), before.begin(), before.end());
      const double dt_s = chain_.t_mid_s[k] - chain_.t_mid_s[k - 1];
      const Eigen::MatrixXd Phi = (process_.F * dt_s).exp();
      const Eigen::MatrixXd W = Whitening(process_.P - Phi * process_.P * Phi.transpose(),
                                          "the noise over " + std::to_string(dt_s) + " s");
      Eigen::MatrixXd R(n_, 2 * n_);
      R << -W * Phi, W;
      AddFactor(blocks, R);
    }
  }

 private:
  static std::string Size(const Eigen::MatrixXd& M) {
    return std::to_string(M.rows()) + " x " + std::to_string(M.cols());
  }

  /// Returns the ids of the blocks that contain the states of interval k.
  std::vector<BlockId> AddStates(std::size_t k) {
    std::vector<BlockId> ids{chain_.blocks[k].id};
    if (n_ == 1) return ids;
    const Eigen::VectorXd start = Eigen::VectorXd::Zero(kAxisCount * (n_ - 1));
    ids.push_back(net_.AddBlock(chain_.name + "/states/" + std::to_string(k),
                                VectorKind(static_cast<int>(start.size())), start));
    net_.SetLabel(ids.back(), {chain_.name + " states", {}, "", 1.0, chain_.t_mid_s[k]});
    return ids;
  }

  /// Returns W with W^T W = C^-1.
  Eigen::MatrixXd Whitening(const Eigen::MatrixXd& C, const std::string& name) const {
    const Eigen::LLT<Eigen::MatrixXd> llt(C);
    if (!C.allFinite() || llt.info() != Eigen::Success) {
      throw InvalidInput("process of '" + chain_.name + "': " + name +
                         " is not positive definite; P must be the stationary covariance of F");
    }
    return llt.matrixL().solve(Eigen::MatrixXd::Identity(n_, n_));
  }

  void AddFactor(const std::vector<BlockId>& blocks, const Eigen::MatrixXd& R) {
    std::vector<BlockKind> kinds;
    for (const BlockId id : blocks) kinds.push_back(net_.block(id).kind);
    const Eigen::VectorXd center = Eigen::VectorXd::Zero(kAxisCount * R.cols());
    net_.AddFactor(std::make_shared<LinearPrior>(kinds, center, OnAllAxes(R),
                                                 Eigen::VectorXd::Zero(kAxisCount * R.rows())),
                   blocks);
  }

  const StationaryProcess& process_;
  const ProcessChain& chain_;
  Network& net_;
  Eigen::Index n_;
};

}  // namespace

StationaryProcess StationaryProcess::SecondOrder(double sigma, double omega) {
  for (const double value : {sigma, omega}) {
    if (!(value > 0.0) || !std::isfinite(value)) {
      throw InvalidInput("second-order process: sigma is " + std::to_string(sigma) +
                         " and omega is " + std::to_string(omega) +
                         ", both must be positive and finite");
    }
  }
  StationaryProcess process;
  process.F = Eigen::Matrix2d{{0.0, 1.0}, {-omega * omega, -2.0 * omega}};
  process.P = (sigma * sigma) * Eigen::Vector2d(1.0, omega * omega).asDiagonal().toDenseMatrix();
  return process;
}

void AddStationaryProcess(const StationaryProcess& process, const ProcessChain& chain,
                          Network* net) {
  StationaryChain(process, chain, net).AddAll();
}

}  // namespace dn
