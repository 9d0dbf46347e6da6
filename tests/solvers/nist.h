#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <cmath>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace dn::testing {

/// A reference data set of the NIST/ITL StRD with its certified values. x[k][i] is predictor k of
/// observation i.
struct NistData {
  std::vector<std::vector<double>> starts;  ///< initial parameters; empty if the model is linear
  std::vector<double> certified;
  std::vector<double> sigma;  ///< certified standard deviations, scaled by the residuals
  double sum_of_squares = 0.0;
  std::vector<std::vector<double>> x;
  std::vector<double> y;

  int observations() const { return static_cast<int>(y.size()); }
  int parameters() const { return static_cast<int>(certified.size()); }
};

/// Reads tests/solvers/nist/<name>.txt. Its lines have a keyword and numbers; after "x n" and "y n"
/// follow n numbers.
inline NistData ReadNist(const std::string& name) {
  const std::string path = std::string(DN_NIST_DIR) + "/" + name + ".txt";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot open " + path);
  NistData data;
  std::string word, line;
  std::getline(file, line);
  const auto numbers = [&](std::size_t n) {
    std::vector<double> values(n);
    for (double& value : values) file >> value;
    return values;
  };
  while (file >> word) {
    if (word == "x" || word == "y") {
      std::size_t n = 0;
      file >> n;
      (word == "x" ? data.x.emplace_back() : data.y) = numbers(n);
      continue;
    }
    std::getline(file, line);
    std::vector<double> values;
    for (std::size_t at = 0, used = 0; at < line.size(); at += used) {
      if (line.find_first_not_of(' ', at) == std::string::npos) break;
      values.push_back(std::stod(line.substr(at), &used));
    }
    if (word == "start") data.starts.push_back(values);
    if (word == "certified") data.certified = values;
    if (word == "sigma") data.sigma = values;
    if (word == "sum_of_squares") data.sum_of_squares = values.at(0);
  }
  return data;
}

/// Returns the number of digits to which a value agrees with a certified one, at most 11 because
/// only 11 digits are certified.
inline double AgreeingDigits(double value, double certified) {
  const double error = certified == 0.0 ? std::abs(value) : std::abs(value / certified - 1.0);
  if (std::isnan(error)) return 0.0;
  return std::min(11.0, -std::log10(std::max(error, 1e-300)));
}

/// A model y = f(b, x) with kParameters parameters b that is fitted to a data set.
struct Exponential {  // Misra1a, BoxBOD
  static constexpr int kParameters = 2;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    return b[0] * (1.0 - exp(-b[1] * x));
  }
};

struct Misra1b {
  static constexpr int kParameters = 2;
  template <class B>
  static auto Value(const B& b, double x) {
    const auto d = 1.0 + b[1] * (0.5 * x);
    return b[0] * (1.0 - 1.0 / (d * d));
  }
};

struct Misra1c {
  static constexpr int kParameters = 2;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::sqrt;
    return b[0] * (1.0 - 1.0 / sqrt(1.0 + b[1] * (2.0 * x)));
  }
};

struct Misra1d {
  static constexpr int kParameters = 2;
  template <class B>
  static auto Value(const B& b, double x) {
    return b[0] * b[1] * x / (1.0 + b[1] * x);
  }
};

struct Chwirut {
  static constexpr int kParameters = 3;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    return exp(-b[0] * x) / (b[1] + b[2] * x);
  }
};

struct Lanczos {
  static constexpr int kParameters = 6;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    return b[0] * exp(-b[1] * x) + b[2] * exp(-b[3] * x) + b[4] * exp(-b[5] * x);
  }
};

struct Gauss {
  static constexpr int kParameters = 8;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    const auto u = (x - b[3]) / b[4], v = (x - b[6]) / b[7];
    return b[0] * exp(-b[1] * x) + b[2] * exp(-u * u) + b[5] * exp(-v * v);
  }
};

struct Power {  // DanWood
  static constexpr int kParameters = 2;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    return b[0] * exp(b[1] * std::log(x));
  }
};

struct Kirby2 {
  static constexpr int kParameters = 5;
  template <class B>
  static auto Value(const B& b, double x) {
    return (b[0] + x * (b[1] + x * b[2])) / (1.0 + x * (b[3] + x * b[4]));
  }
};

struct Cubics {  // Hahn1, Thurber
  static constexpr int kParameters = 7;
  template <class B>
  static auto Value(const B& b, double x) {
    return (b[0] + x * (b[1] + x * (b[2] + x * b[3]))) / (1.0 + x * (b[4] + x * (b[5] + x * b[6])));
  }
};

struct Nelson {
  static constexpr int kParameters = 3;
  template <class B>
  static auto Value(const B& b, double x1, double x2) {
    using std::exp;
    return b[0] - b[1] * x1 * exp(-b[2] * x2);
  }
};

struct Mgh17 {
  static constexpr int kParameters = 5;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    return b[0] + b[1] * exp(-b[3] * x) + b[2] * exp(-b[4] * x);
  }
};

struct Roszman1 {
  static constexpr int kParameters = 4;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::atan;
    return b[0] - b[1] * x - atan(b[2] / (x - b[3])) * (1.0 / M_PI);
  }
};

struct Enso {
  static constexpr int kParameters = 9;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::cos;
    using std::sin;
    const double year = 2.0 * M_PI * x / 12.0;
    const auto u = 2.0 * M_PI * x / b[3], v = 2.0 * M_PI * x / b[6];
    return b[0] + b[1] * std::cos(year) + b[2] * std::sin(year) + b[4] * cos(u) + b[5] * sin(u) +
           b[7] * cos(v) + b[8] * sin(v);
  }
};

struct Mgh09 {
  static constexpr int kParameters = 4;
  template <class B>
  static auto Value(const B& b, double x) {
    return b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]);
  }
};

struct Mgh10 {
  static constexpr int kParameters = 3;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    return b[0] * exp(b[1] / (x + b[2]));
  }
};

struct Rat42 {
  static constexpr int kParameters = 3;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    return b[0] / (1.0 + exp(b[1] - b[2] * x));
  }
};

struct Rat43 {
  static constexpr int kParameters = 4;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    using std::pow;
    return b[0] / pow(1.0 + exp(b[1] - b[2] * x), 1.0 / b[3]);
  }
};

struct Eckerle4 {
  static constexpr int kParameters = 3;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::exp;
    const auto u = (x - b[2]) / b[1];
    return b[0] / b[1] * exp(-0.5 * u * u);
  }
};

struct Bennett5 {
  static constexpr int kParameters = 3;
  template <class B>
  static auto Value(const B& b, double x) {
    using std::pow;
    return b[0] * pow(b[1] + x, -1.0 / b[2]);
  }
};

struct Proportion {  // NoInt1, NoInt2
  static constexpr int kParameters = 1;
  template <class B>
  static auto Value(const B& b, double x) {
    return b[0] * x;
  }
};

template <int kDegree>
struct Polynomial {  // Norris, Pontius, Wampler, Filip
  static constexpr int kParameters = kDegree + 1;
  template <class B>
  static auto Value(const B& b, double x) {
    auto value = b[kDegree] * 1.0;
    for (int k = kDegree - 1; k >= 0; --k) value = value * x + b[k];
    return value;
  }
};

struct Longley {
  static constexpr int kParameters = 7;
  template <class B, class... X>
  static auto Value(const B& b, X... x) {
    const double predictors[] = {x...};
    auto value = b[0] * 1.0;
    for (int k = 0; k < 6; ++k) value += b[k + 1] * predictors[k];
    return value;
  }
};

/// Adds the parameters as one block and every observation as a factor of unit weight. For Nelson, y
/// is the logarithm of the data.
template <class Model, int kPredictors = 1>
Block<Vec<Model::kParameters>> AddNist(const NistData& data, const std::vector<double>& start,
                                       Network* net) {
  constexpr int kParameters = Model::kParameters;
  const auto b = net->AddVector<kParameters>(
      "b", Eigen::Map<const Eigen::Matrix<double, kParameters, 1>>(start.data()));
  for (std::size_t i = 0; i < data.y.size(); ++i) {
    const double y = std::is_same_v<Model, Nelson> ? std::log(data.y[i]) : data.y[i];
    std::array<double, kPredictors> x;
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = data.x[k][i];
    const auto residual = [x, y](const auto& parameters) {
      return std::apply([&](auto... xs) { return Model::Value(parameters, xs...) - y; }, x);
    };
    net->Add(residual, Noise<1>::Sigma(1.0), b);
  }
  return b;
}

}  // namespace dn::testing
