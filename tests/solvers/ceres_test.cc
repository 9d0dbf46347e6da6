#include <ceres/autodiff_cost_function.h>
#include <ceres/covariance.h>
#include <ceres/dynamic_autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/solver.h>
#include <ceres/sphere_manifold.h>
#include <dn/ceres.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "solvers/pose_graph.h"
#include "testing/ceres_errors.h"
#include "testing/random.h"

namespace dn::solvers_test {

using testing::RelativePoseError;
using testing::Reprojection;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Rounding of two factorisations, relative to the sigmas.
constexpr double kCeresTolerance = 1e-7;

void Solve(ceres::Problem* problem) {
  ceres::Solver::Options options;
  options.function_tolerance = 1e-15;
  options.parameter_tolerance = 1e-14;
  options.gradient_tolerance = 1e-14;
  options.max_num_iterations = 200;
  options.logging_type = ceres::SILENT;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  ASSERT_TRUE(summary.IsSolutionUsable()) << summary.message;
}

/// Compares all diagonal blocks, and the blocks with the first unknown, with ceres::Covariance.
void ExpectSameAsCeres(ceres::Problem& problem, double tolerance = kCeresTolerance) {
  std::vector<double*> blocks;
  problem.GetParameterBlocks(&blocks);
  std::erase_if(blocks, [&](double* x) {
    return problem.IsParameterBlockConstant(x) || problem.ParameterBlockTangentSize(x) == 0;
  });
  std::vector<std::pair<const double*, const double*>> pairs;
  for (const double* x : blocks) {
    pairs.emplace_back(x, x);
    if (x != blocks[0]) pairs.emplace_back(blocks[0], x);
  }
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::SPARSE_QR;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  ceres::Covariance reference(options);
  ASSERT_TRUE(reference.Compute(pairs, &problem));
  const Marginals marginals(problem);
  for (const auto& [a, b] : pairs) {
    RowMajor expected(problem.ParameterBlockTangentSize(a), problem.ParameterBlockTangentSize(b));
    ASSERT_TRUE(reference.GetCovarianceBlockInTangentSpace(a, b, expected.data()));
    const Eigen::MatrixXd got = marginals.Covariance(a, b);
    ASSERT_EQ(got.rows(), expected.rows());
    ASSERT_EQ(got.cols(), expected.cols());
    const Eigen::VectorXd sigma_a = marginals.Covariance(a).diagonal().cwiseSqrt();
    const Eigen::VectorXd sigma_b = marginals.Covariance(b).diagonal().cwiseSqrt();
    const Eigen::MatrixXd difference = sigma_a.cwiseInverse().asDiagonal() * (got - expected) *
                                       sigma_b.cwiseInverse().asDiagonal();
    EXPECT_LE(difference.lpNorm<Eigen::Infinity>(), tolerance);
  }
}

TEST(CeresManifold, HasTheTangentOfTheKind) {
  std::mt19937 rng(1);
  const Eigen::Quaterniond q = testing::RandomRotation(rng);
  const Eigen::Vector3d d(0.3, -0.2, 0.5);
  Eigen::VectorXd pose(7), step(6);
  pose << q.coeffs(), 1.0, 2.0, 3.0;
  step << d, 0.4, 0.5, 0.6;
  const auto expect = [](const BlockKind& kind, const Eigen::VectorXd& x,
                         const Eigen::VectorXd& dx) {
    const std::unique_ptr<ceres::Manifold> manifold = MakeCeresManifold(kind);
    ASSERT_EQ(manifold->AmbientSize(), x.size());
    ASSERT_EQ(manifold->TangentSize(), dx.size());
    Eigen::VectorXd y(x.size()), expected(x.size()), back(dx.size());
    ASSERT_TRUE(manifold->Plus(x.data(), dx.data(), y.data()));
    Plus(kind, x.data(), dx.data(), expected.data());
    EXPECT_EQ(y, expected);
    ASSERT_TRUE(manifold->Minus(y.data(), x.data(), back.data()));
    EXPECT_LE((back - dx).norm(), 1e-14);
    RowMajor J(x.size(), dx.size()), lift(dx.size(), x.size());
    ASSERT_TRUE(manifold->PlusJacobian(x.data(), J.data()));
    ASSERT_TRUE(manifold->MinusJacobian(x.data(), lift.data()));
    EXPECT_LE((J - PlusJacobian(kind, x.data())).norm(), 1e-14);
    EXPECT_LE((lift * J - Eigen::MatrixXd::Identity(dx.size(), dx.size())).norm(), 1e-14);
  };
  expect(Rotation::kKind, q.coeffs(), d);
  expect(LeftRotation::kKind, q.coeffs(), d);
  expect(MakeBlockKind<Pose>(), pose, step);
  expect(VectorKind(3), d, d);
  EXPECT_EQ(MakeCeresManifold<Rotation>()->TangentSize(), 3);
}

// The same pose graph in a plain Ceres program and in a network.
TEST(CeresCostFunction, GivesTheSolutionAndSigmasOfTheNetwork) {
  testing::PoseGraph graph = testing::MakePoseGraph(4, {.noise = 1.0});
  Network& net = graph.network;
  std::vector<Eigen::VectorXd> values;
  for (BlockId b = 0; b < net.num_blocks(); ++b) values.push_back(net.Value(b));
  ceres::Problem problem;
  for (BlockId b = 0; b < net.num_blocks(); ++b) {
    const BlockKind& kind = net.block(b).kind;
    problem.AddParameterBlock(values[static_cast<std::size_t>(b)].data(), kind.stored_size,
                              MakeCeresManifold(kind).release());
    if (net.block(b).held) {
      problem.SetParameterBlockConstant(values[static_cast<std::size_t>(b)].data());
    }
  }
  for (FactorId id = 0; id < net.num_factors(); ++id) {
    std::vector<double*> x;
    for (const BlockId b : net.factor(id).blocks) {
      x.push_back(values[static_cast<std::size_t>(b)].data());
    }
    problem.AddResidualBlock(MakeCostFunction(net.factor(id).factor).release(), nullptr, x);
  }
  Solve(&problem);
  EXPECT_TRUE(dn::Solve(net).converged);
  const Marginals expected(net), got(problem);
  for (BlockId b = 0; b < net.num_blocks(); ++b) {
    const double* x = values[static_cast<std::size_t>(b)].data();
    Eigen::VectorXd difference(net.block(b).kind.tangent_size);
    Minus(net.block(b).kind, x, net.Value(b).data(), difference.data());
    EXPECT_LE(difference.norm(), 1e-7);
    if (net.block(b).held) continue;
    EXPECT_LE((got.Covariance(x) - expected.Covariance(b)).norm(),
              1e-6 * expected.Covariance(b).norm());
  }
  ExpectSameAsCeres(problem);
}

TEST(CeresCostFunction, TakesFactorsAndFunctions) {
  double x[2] = {3.0, 4.0}, scale = 2.0;
  ceres::Problem problem;
  problem.AddResidualBlock(
      MakeCostFunction<Vec<2>, Scalar>(
          [](const auto& p, const auto& s) { return s * p.norm() - 11.0; }, Noise<1>::Sigma(0.5))
          .release(),
      nullptr, x, &scale);
  problem.AddResidualBlock(
      MakeCostFunction(testing::MakeVectorPrior<2>(Eigen::Vector2d(3.0, 4.0), 0.1)).release(),
      nullptr, x);
  double cost = 0.0;
  ASSERT_TRUE(problem.Evaluate({}, &cost, nullptr, nullptr, nullptr));
  EXPECT_NEAR(cost, 0.5 * 4.0, 1e-12);
  Solve(&problem);
  EXPECT_NEAR(scale, 2.2, 1e-9);
  EXPECT_THROW(MakeCostFunction(std::shared_ptr<const FactorBase>()), InvalidInput);
}

struct ThrowingFactor : AutoFactor<ThrowingFactor, 1, Scalar> {
  template <class T>
  bool Residual(const T*, T*) const {
    throw std::logic_error("no model");
  }
};

TEST(CeresCostFunction, FailsWhereItsFactorThrows) {
  double x = 0.0;
  ceres::Problem problem;
  problem.AddResidualBlock(MakeCostFunction(ThrowingFactor()).release(), nullptr, &x);
  double cost = 0.0;
  EXPECT_FALSE(problem.Evaluate({}, &cost, nullptr, nullptr, nullptr));
  EXPECT_THROW(Marginals{problem}, InvalidInput);
  Network net;
  net.Add(ThrowingFactor(), net.AddScalar("x", 0.0));
  NetworkProblem of_network(net);
  EXPECT_FALSE(of_network.problem().Evaluate({}, &cost, nullptr, nullptr, nullptr));
  EXPECT_THAT([&] { of_network.RethrowFactorException(); },
              ::testing::ThrowsMessage<InvalidInput>(::testing::HasSubstr("no model")));
}

// A network becomes a problem and this becomes a network: covariances and losses stay.
TEST(NetworkProblem, MovesTheNetworkAndComesBack) {
  testing::PoseGraph graph = testing::MakePoseGraph(5, {.noise = 1.0});
  graph.network.SetLoss(graph.relative[3], Loss::Huber(0.5));
  graph.network.SetLoss(graph.relative[4], Loss::Cauchy(0.5));
  Network solved = graph.network;
  EXPECT_TRUE(dn::Solve(solved).converged);
  NetworkProblem problem(graph.network);
  Solve(&problem.problem());
  EXPECT_LE((graph.network.Value(graph.p_mb[7]) - solved.Value(graph.p_mb[7])).norm(), 1e-6);
  const Marginals direct(graph.network), round_trip(problem.problem());
  const double* p = graph.network.block(graph.p_mb[7].id).value.get();
  EXPECT_LE((direct.Covariance(graph.p_mb[7]) - round_trip.Covariance(p)).norm(),
            1e-9 * direct.Covariance(graph.p_mb[7]).norm());
}

struct Measured {
  double z, sigma;
  template <class T>
  bool operator()(const T* x, T* r) const {
    r[0] = (x[0] - z) / sigma;
    return true;
  }
};

TEST(ProblemNetwork, SolvesWithNamesAndStoresValues) {
  double x = 0.0, unused = 7.0;
  ceres::Problem problem;
  problem.AddParameterBlock(&unused, 1);
  for (const double z : {1.0, 2.0, 6.0}) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Measured, 1, 1>(new Measured{z, 0.1}),
                             nullptr, &x);
  }
  ProblemNetwork network(problem, {{&x, "height"}});
  EXPECT_EQ(network.network().block(network.Find(&x)).name, "height");
  EXPECT_TRUE(dn::Solve(network.network()).converged);
  EXPECT_EQ(x, 0.0);
  network.StoreValues();
  EXPECT_NEAR(x, 3.0, 1e-7);  // the last step is damped
  EXPECT_EQ(unused, 7.0);
  EXPECT_THROW(network.Find(nullptr), InvalidInput);
  EXPECT_THROW(Marginals(network.network()).Covariance(&x), InvalidInput);
  EXPECT_NEAR(Marginals(problem).Covariance(&x)(0, 0), 0.01 / 3.0, 1e-12);
}

// Every loss function of Ceres downweights by its rho'.
TEST(ProblemNetwork, TakesTheLossFunctionsOfCeres) {
  const std::vector<ceres::LossFunction*> losses{
      nullptr,
      new ceres::TrivialLoss(),
      new ceres::HuberLoss(1.5),
      new ceres::SoftLOneLoss(1.5),
      new ceres::CauchyLoss(1.5),
      new ceres::ArctanLoss(20.0),
      new ceres::TukeyLoss(9.0),
      new ceres::ScaledLoss(new ceres::HuberLoss(1.5), 3.0, ceres::TAKE_OWNERSHIP)};
  for (ceres::LossFunction* loss : losses) {
    double x = 0.0;
    ceres::Problem::Options options;
    ceres::Problem problem(options);
    for (const double z : {0.0, 0.5, 1.0, 0.3, -0.4}) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Measured, 1, 1>(new Measured{z, 0.2}), loss, &x);
    }
    Solve(&problem);
    ExpectSameAsCeres(problem);
    ProblemNetwork network(problem);
    EXPECT_TRUE(dn::Solve(network.network()).converged);
    EXPECT_NEAR(network.network().Value(network.Find(&x))[0], x, 1e-6);
  }
}

// Parts of a block are constant, a direction is on the sphere, and a quaternion has the half angle.
TEST(ProblemNetwork, TakesTheManifoldsOfCeres) {
  double part[4] = {1.0, 2.0, 3.0, 4.0}, direction[3] = {0.6, 0.0, 0.8}, all_constant[2] = {1, 2};
  Eigen::Quaterniond q(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()));
  double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  ceres::Problem problem;
  problem.AddParameterBlock(part, 4, new ceres::SubsetManifold(4, {1, 3}));
  problem.AddParameterBlock(direction, 3, new ceres::SphereManifold<3>());
  problem.AddParameterBlock(q.coeffs().data(), 4, new ceres::EigenQuaternionManifold());
  problem.AddParameterBlock(wxyz, 4, new ceres::QuaternionManifold());
  problem.AddParameterBlock(all_constant, 2, new ceres::SubsetManifold(2, {0, 1}));
  std::mt19937 rng(3);
  const auto add = [&](double* x, int size, double* y, int other_size) {
    const Eigen::MatrixXd A = testing::RandomVector(rng, 1.0).asDiagonal() *
                              Eigen::MatrixXd::Random(3, size + other_size);
    const auto residual = [A, size, other_size](auto const* const* p, auto* r) {
      for (int i = 0; i < 3; ++i) {
        r[i] = A(i, 0) * p[0][0];
        for (int k = 1; k < size; ++k) r[i] += A(i, k) * p[0][k];
        for (int k = 0; k < other_size; ++k) r[i] += A(i, size + k) * p[1][k];
      }
      return true;
    };
    auto cost = std::make_unique<ceres::DynamicAutoDiffCostFunction<decltype(residual)>>(
        new auto(residual));
    cost->AddParameterBlock(size);
    cost->AddParameterBlock(other_size);
    cost->SetNumResiduals(3);
    problem.AddResidualBlock(cost.release(), nullptr, x, y);
  };
  for (int k = 0; k < 3; ++k) {
    add(part, 4, direction, 3);
    add(direction, 3, q.coeffs().data(), 4);
    add(q.coeffs().data(), 4, wxyz, 4);
    add(wxyz, 4, all_constant, 2);
  }
  ExpectSameAsCeres(problem);
  EXPECT_EQ(Marginals(problem).Covariance(part).rows(), 2);
}

/// Returns a bundle adjustment in the text format of the public BAL problems: numbers of cameras,
/// points and observations; observations; cameras; points.
std::string BundleAdjustment(int cameras, int points) {
  std::mt19937 rng(8);
  std::normal_distribution<double> normal;
  std::vector<std::array<double, 9>> camera;
  std::vector<Eigen::Vector3d> point;
  for (int c = 0; c < cameras; ++c) {
    camera.push_back({0.05 * normal(rng), 0.05 * normal(rng), 0.05 * normal(rng), c - 0.5 * cameras,
                      0.3 * normal(rng), -10.0 + 0.3 * normal(rng), 800.0, -1e-2, 1e-3});
  }
  for (int p = 0; p < points; ++p) {
    point.emplace_back(3.0 * normal(rng), 3.0 * normal(rng), 1.5 * normal(rng));
  }
  std::ostringstream text;
  text.precision(17);
  text << cameras << ' ' << points << ' ' << cameras * points << '\n';
  for (int p = 0; p < points; ++p) {
    for (int c = 0; c < cameras; ++c) {
      double r[2];
      Reprojection{0.0, 0.0}(camera[static_cast<std::size_t>(c)].data(),
                             point[static_cast<std::size_t>(p)].data(), r);
      text << c << ' ' << p << ' ' << r[0] + 0.5 * normal(rng) << ' ' << r[1] + 0.5 * normal(rng)
           << '\n';
    }
  }
  for (const auto& numbers : camera) {
    for (const double number : numbers) text << number << '\n';
  }
  for (const Eigen::Vector3d& numbers : point) text << numbers << '\n';
  return text.str();
}

TEST(ProblemNetwork, OfABundleAdjustmentHasTheCovarianceOfCeres) {
  std::istringstream text(BundleAdjustment(5, 40));
  int cameras = 0, points = 0, observations = 0;
  text >> cameras >> points >> observations;
  struct Observation {
    int camera, point;
    double u, v;
  };
  std::vector<Observation> seen(static_cast<std::size_t>(observations));
  for (Observation& o : seen) text >> o.camera >> o.point >> o.u >> o.v;
  std::vector<std::array<double, 9>> camera(static_cast<std::size_t>(cameras));
  std::vector<std::array<double, 3>> point(static_cast<std::size_t>(points));
  for (auto& numbers : camera) {
    for (double& number : numbers) text >> number;
  }
  for (auto& numbers : point) {
    for (double& number : numbers) text >> number;
  }
  ceres::Problem problem;
  for (const Observation& o : seen) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Reprojection, 2, 9, 3>(new Reprojection{o.u, o.v}), nullptr,
        camera[static_cast<std::size_t>(o.camera)].data(),
        point[static_cast<std::size_t>(o.point)].data());
  }
  // The first camera defines position and attitude, a coordinate of the second the scale.
  problem.SetManifold(camera[0].data(), new ceres::SubsetManifold(9, {0, 1, 2, 3, 4, 5}));
  problem.SetManifold(camera[1].data(), new ceres::SubsetManifold(9, {3}));
  Solve(&problem);
  ExpectSameAsCeres(problem, 1e-5);
}

TEST(ProblemNetwork, OfAG2oFileHasTheCovarianceOfCeres) {
  std::ifstream file(DN_G2O_FILE);
  ASSERT_TRUE(file);
  std::vector<Eigen::Vector3d> p;
  std::vector<Eigen::Quaterniond> q;
  p.reserve(1000);
  q.reserve(1000);
  ceres::Problem problem;
  ceres::Manifold* quaternion = new ceres::EigenQuaternionManifold();
  std::string tag;
  while (file >> tag) {
    if (tag == "VERTEX_SE3:QUAT") {
      std::size_t id = 0;
      Eigen::Vector3d position;
      Eigen::Quaterniond attitude;
      file >> id >> position[0] >> position[1] >> position[2] >> attitude.x() >> attitude.y() >>
          attitude.z() >> attitude.w();
      ASSERT_EQ(id, p.size());
      p.push_back(position);
      q.push_back(attitude.normalized());
      problem.AddParameterBlock(p.back().data(), 3);
      problem.AddParameterBlock(q.back().coeffs().data(), 4, quaternion);
      continue;
    }
    if (tag == "FIX") {
      std::size_t id = 0;
      file >> id;
      problem.SetParameterBlockConstant(p[id].data());
      problem.SetParameterBlockConstant(q[id].coeffs().data());
      continue;
    }
    ASSERT_EQ(tag, "EDGE_SE3:QUAT");
    std::size_t a = 0, b = 0;
    RelativePoseError error;
    Eigen::Matrix<double, 6, 6> information;
    file >> a >> b >> error.p[0] >> error.p[1] >> error.p[2] >> error.q.x() >> error.q.y() >>
        error.q.z() >> error.q.w();
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) {
        file >> information(i, j);
        information(j, i) = information(i, j);
      }
    }
    error.sqrt_information = information.llt().matrixU();
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<RelativePoseError, 6, 3, 4, 3, 4>(
                                 new RelativePoseError(error)),
                             nullptr, p[a].data(), q[a].coeffs().data(), p[b].data(),
                             q[b].coeffs().data());
  }
  ASSERT_GT(p.size(), 10U);
  Solve(&problem);
  ExpectSameAsCeres(problem);
}

}  // namespace dn::solvers_test
