#include <dn/error.h>
#include <dn/report/json.h>
#include <dn/report/json_reader.h>
#include <dn/report/network_file.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <utility>

namespace dn {
namespace {

constexpr std::string_view kMagic = "dn.net1\n";
constexpr const char* kSchema = "dn.network/1";
constexpr std::size_t kMostItems = 10'000'000;

constexpr std::array<std::pair<Parametrisation, const char*>, 4> kParametrisations{
    {{Parametrisation::kVector, "vector"},
     {Parametrisation::kRotationRight, "rotation_right"},
     {Parametrisation::kRotationLeft, "rotation_left"},
     {Parametrisation::kManifold, "manifold"}}};

Json StateJson(const NetworkState& state) {
  Json blocks = Json::array(), priors = Json::array();
  for (const NetworkState::Block& block : state.blocks) {
    const auto* name =
        std::find_if(kParametrisations.begin(), kParametrisations.end(),
                     [&](const auto& p) { return p.first == block.parametrisation; });
    blocks.push_back(
        {{"name", block.name},
         {"parametrisation", name->second},
         {"value", ToJson(block.value)},
         {"covariance", block.covariance.size() == 0 ? Json() : ToJsonMatrix(block.covariance)}});
  }
  for (const NetworkState::Prior& prior : state.priors) {
    priors.push_back(
        {{"group", prior.group},
         {"blocks", prior.blocks},
         {"center", ToJson(prior.center)},
         {"R", ToJsonMatrix(prior.R)},
         {"d", ToJson(prior.d)},
         {"nonlinearity", std::isfinite(prior.nonlinearity) ? Json(prior.nonlinearity) : Json()}});
  }
  return {{"schema", kSchema}, {"blocks", blocks}, {"priors", priors}};
}

Eigen::VectorXd VectorAt(const JsonPlace& place) {
  const std::vector<JsonPlace> elements = place.Elements(kMostItems);
  Eigen::VectorXd v(static_cast<Eigen::Index>(elements.size()));
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = elements[static_cast<std::size_t>(i)].Number();
  return v;
}

Eigen::MatrixXd MatrixAt(const JsonPlace& place) {
  const std::vector<JsonPlace> rows = place.Elements(kMostItems);
  Eigen::MatrixXd M;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Eigen::VectorXd row = VectorAt(rows[i]);
    if (i == 0) M.resize(static_cast<Eigen::Index>(rows.size()), row.size());
    if (row.size() != M.cols()) rows[i].Fail("the rows of a matrix have different lengths");
    M.row(static_cast<Eigen::Index>(i)) = row.transpose();
  }
  return M;
}

/// JSON has null for infinity.
double NonlinearityAt(const JsonPlace& place) {
  return place.is_null() ? std::numeric_limits<double>::infinity() : place.Number(0.0);
}

Parametrisation ParametrisationAt(const JsonPlace& place) {
  const std::string text = place.Text();
  for (const auto& [parametrisation, name] : kParametrisations) {
    if (text == name) return parametrisation;
  }
  place.Fail("must be vector, rotation_right, rotation_left or manifold");
}

NetworkState StateFromJson(std::string_view content, const std::string& file) {
  const Json json = ParseJson(content, file, {.values = kMostItems});
  const JsonPlace root(json, file);
  if (root.At("schema").Text() != kSchema) {
    root.At("schema").Fail(std::string("must be ") + kSchema);
  }
  NetworkState state;
  for (const JsonPlace& place : root.At("blocks").Elements(kMostItems)) {
    const JsonPlace covariance = place.At("covariance");
    state.blocks.push_back({place.At("name").Text(), ParametrisationAt(place.At("parametrisation")),
                            VectorAt(place.At("value")),
                            covariance.is_null() ? Eigen::MatrixXd() : MatrixAt(covariance)});
  }
  for (const JsonPlace& place : root.At("priors").Elements(kMostItems)) {
    state.priors.push_back({place.At("group").Text(), ReadTexts(place.At("blocks")),
                            VectorAt(place.At("center")), MatrixAt(place.At("R")),
                            VectorAt(place.At("d")), NonlinearityAt(place.At("nonlinearity"))});
  }
  return state;
}

/// Appends little-endian numbers, texts and matrices to a file's content.
class BinaryWriter {
 public:
  explicit BinaryWriter(std::string* out) : out_(*out) {}
  void Count(std::size_t value) { Number(static_cast<std::uint64_t>(value)); }
  void Text(const std::string& text) {
    Count(text.size());
    out_ += text;
  }
  void Matrix(const Eigen::Ref<const Eigen::MatrixXd>& M) {
    Count(static_cast<std::size_t>(M.rows()));
    Count(static_cast<std::size_t>(M.cols()));
    for (const double value : M.reshaped()) Number(std::bit_cast<std::uint64_t>(value));
  }

 private:
  void Number(std::uint64_t bits) {
    for (int shift = 0; shift < 64; shift += 8) out_ += static_cast<char>((bits >> shift) & 0xFFU);
  }
  std::string& out_;
};

class BinaryReader {
 public:
  BinaryReader(std::string_view content, std::string file)
      : rest_(content), size_(content.size()), file_(std::move(file)) {}

  std::size_t Count() {
    const std::uint64_t value = Number();
    // Every item has at least one byte, so that a wrong count cannot fill the memory.
    if (value > rest_.size()) Fail("a count exceeds the rest of the file");
    return static_cast<std::size_t>(value);
  }
  std::string Text() {
    const std::size_t length = Count();
    return std::string(Take(length));
  }
  Eigen::MatrixXd Matrix() {
    const std::size_t rows = Count(), cols = Count();
    if (rows > 0 && cols > rest_.size() / 8 / rows) Fail("a matrix exceeds the rest of the file");
    Eigen::MatrixXd M(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
    for (double& value : M.reshaped()) value = std::bit_cast<double>(Number());
    return M;
  }
  Eigen::VectorXd Vector() {
    const Eigen::MatrixXd M = Matrix();
    if (M.cols() != 1) Fail("a vector has " + std::to_string(M.cols()) + " columns");
    return M.col(0);
  }
  void ExpectEnd() const {
    if (!rest_.empty()) Fail("there are bytes after the end");
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw InvalidInput(
        "network state: " + what + " (byte " + std::to_string(size_ - rest_.size()) + ")", {file_});
  }

 private:
  std::string_view Take(std::size_t bytes) {
    if (bytes > rest_.size()) Fail("the file ends too early");
    const std::string_view taken = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return taken;
  }
  std::uint64_t Number() {
    std::uint64_t bits = 0;
    const std::string_view bytes = Take(8);
    for (std::size_t i = 0; i < 8; ++i) {
      bits |= std::uint64_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
    }
    return bits;
  }

  std::string_view rest_;
  std::size_t size_;
  std::string file_;
};

std::string StateBytes(const NetworkState& state) {
  std::string bytes(kMagic);
  BinaryWriter out(&bytes);
  out.Count(state.blocks.size());
  for (const NetworkState::Block& block : state.blocks) {
    out.Text(block.name);
    out.Count(static_cast<std::size_t>(block.parametrisation));
    out.Matrix(block.value);
    out.Matrix(block.covariance);
  }
  out.Count(state.priors.size());
  for (const NetworkState::Prior& prior : state.priors) {
    out.Text(prior.group);
    out.Count(prior.blocks.size());
    for (const std::string& name : prior.blocks) out.Text(name);
    out.Matrix(prior.center);
    out.Matrix(prior.R);
    out.Matrix(prior.d);
    out.Matrix(Eigen::Matrix<double, 1, 1>(prior.nonlinearity));
  }
  return bytes;
}

NetworkState StateFromBytes(std::string_view content, const std::string& file) {
  BinaryReader in(content, file);
  NetworkState state;
  const std::size_t blocks = in.Count();
  for (std::size_t k = 0; k < blocks; ++k) {
    NetworkState::Block block;
    block.name = in.Text();
    const std::size_t parametrisation = in.Count();
    if (parametrisation >= kParametrisations.size()) in.Fail("unknown parametrisation");
    block.parametrisation = kParametrisations[parametrisation].first;
    block.value = in.Vector();
    block.covariance = in.Matrix();
    state.blocks.push_back(std::move(block));
  }
  const std::size_t priors = in.Count();
  for (std::size_t k = 0; k < priors; ++k) {
    NetworkState::Prior prior;
    prior.group = in.Text();
    const std::size_t names = in.Count();
    for (std::size_t i = 0; i < names; ++i) prior.blocks.push_back(in.Text());
    prior.center = in.Vector();
    prior.R = in.Matrix();
    prior.d = in.Vector();
    const Eigen::VectorXd nonlinearity = in.Vector();
    if (nonlinearity.size() != 1) in.Fail("the nonlinearity of a prior is not one number");
    prior.nonlinearity = nonlinearity[0];
    state.priors.push_back(std::move(prior));
  }
  in.ExpectEnd();
  return state;
}

}  // namespace

std::string FormatState(const NetworkState& state, StateFormat format) {
  return format == StateFormat::kJson ? FormatJson(StateJson(state)) : StateBytes(state);
}

NetworkState ParseState(std::string_view content, const std::string& file) {
  if (!content.starts_with(kMagic)) return StateFromJson(content, file);
  return StateFromBytes(content.substr(kMagic.size()), file);
}

void WriteState(const std::filesystem::path& path, const NetworkState& state, StateFormat format) {
  std::ofstream out(path, std::ios::binary);
  out << FormatState(state, format);
  out.close();
  if (!out) throw InvalidInput("network state: cannot write the file", {path.string()});
}

NetworkState ReadState(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InvalidInput("network state: cannot read the file", {path.string()});
  const std::string content{std::istreambuf_iterator<char>(in), {}};
  return ParseState(content, path.string());
}

}  // namespace dn
