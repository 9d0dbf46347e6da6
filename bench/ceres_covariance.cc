#include "ceres_covariance.h"

#include <ceres/covariance.h>
#include <dn/ceres.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <system_error>
#include <utility>

namespace dn::bench {
namespace {

CeresCovariance ComputeHere(ceres::Problem& problem, const std::vector<const double*>& blocks) {
  std::vector<std::pair<const double*, const double*>> pairs;
  for (const double* block : blocks) pairs.emplace_back(block, block);
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::SPARSE_QR;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads = 1;
  ceres::Covariance covariance(options);
  CeresCovariance result;
  const double start_s = ProcessorSeconds();
  const bool computed = covariance.Compute(pairs, &problem);
  result.time_s = ProcessorSeconds() - start_s;
  if (!computed) {
    result.error = "rank deficient";
    return result;
  }
  for (const double* block : blocks) {
    const int size = problem.ParameterBlockTangentSize(block);
    Eigen::MatrixXd C(size, size);
    covariance.GetCovarianceBlockInTangentSpace(block, block, C.data());
    result.covariance.push_back(C);
  }
  return result;
}

/// Packs the time (negative for a failure), followed by the covariances.
std::vector<double> Pack(const CeresCovariance& result) {
  std::vector<double> numbers{result.error.empty() ? result.time_s : -1.0};
  for (const Eigen::MatrixXd& C : result.covariance) {
    numbers.insert(numbers.end(), C.data(), C.data() + C.size());
  }
  return numbers;
}

void WriteAll(int file, const std::vector<double>& numbers) {
  const char* at = reinterpret_cast<const char*>(numbers.data());
  std::size_t left = numbers.size() * sizeof(double);
  while (left > 0) {
    const ssize_t n = write(file, at, left);
    if (n <= 0) return;
    at += n;
    left -= static_cast<std::size_t>(n);
  }
}

/// Reads until `count` bytes have arrived or the other end closes; returns the number of bytes.
std::size_t ReadAll(int file, char* at, std::size_t count) {
  std::size_t done = 0;
  while (done < count) {
    const ssize_t n = read(file, at + done, count - done);
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

void LimitCpu(unsigned limit_s) {
  const rlimit limit{limit_s, limit_s};
  setrlimit(RLIMIT_CPU, &limit);
}

}  // namespace

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

CeresCovariance ComputeByCeres(Network& network, const std::vector<BlockId>& blocks,
                               unsigned limit_s) {
  NetworkProblem problem(network);
  std::vector<const double*> values;
  for (const BlockId b : blocks) values.push_back(network.block(b).value.get());
  return ComputeByCeres(problem.problem(), values, limit_s);
}

CeresCovariance ComputeByCeres(ceres::Problem& problem, const std::vector<const double*>& blocks,
                               unsigned limit_s) {
  int ends[2];
  if (pipe(ends) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child == 0) {
    close(ends[0]);
    LimitCpu(limit_s);
    WriteAll(ends[1], Pack(ComputeHere(problem, blocks)));
    _exit(0);
  }
  close(ends[1]);
  std::size_t count = 1;
  for (const double* block : blocks) {
    const auto size = static_cast<std::size_t>(problem.ParameterBlockTangentSize(block));
    count += size * size;
  }
  std::vector<double> numbers(count);
  const std::size_t bytes =
      ReadAll(ends[0], reinterpret_cast<char*>(numbers.data()), count * sizeof(double));
  waitpid(child, nullptr, 0);
  close(ends[0]);

  CeresCovariance result;
  if (bytes == 0) {
    result.error = "not finished in " + std::to_string(limit_s) + " s of processor time";
  } else if (numbers[0] < 0.0 || bytes < count * sizeof(double)) {
    result.error = "ceres::Covariance takes the problem for rank deficient";
  }
  if (!result.error.empty()) return result;
  result.time_s = numbers[0];
  const double* at = numbers.data() + 1;
  for (const double* block : blocks) {
    const int size = problem.ParameterBlockTangentSize(block);
    result.covariance.emplace_back(Eigen::Map<const Eigen::MatrixXd>(at, size, size));
    at += size * size;
  }
  return result;
}

double LargestDifference(const std::vector<Eigen::MatrixXd>& a,
                         const std::vector<Eigen::MatrixXd>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Eigen::VectorXd scale = b[k].diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd difference = scale.asDiagonal() * (a[k] - b[k]) * scale.asDiagonal();
    largest = std::max(largest, difference.cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace dn::bench
