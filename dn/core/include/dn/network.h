#pragma once

#include <dn/block.h>
#include <dn/error.h>
#include <dn/factor.h>
#include <dn/factor_group.h>
#include <dn/function_factor.h>
#include <dn/manifold.h>
#include <dn/pose.h>

#include <deque>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dn {

/// Handle of a block of a known kind; only valid in the network that gave it.
template <class Kind>
struct Block {
  int id = -1;
};

using BlockId = int;
using FactorId = int;

/// Robust loss rho(s) on the squared norm s of a factor's residual. width is in units of sigma.
struct Loss {
  enum class Type { kNone, kHuber, kCauchy };
  Type type = Type::kNone;
  double width = 1.0;

  /// Quadratic within k sigma, linear beyond.
  static Loss Huber(double k) { return {Type::kHuber, k}; }
  /// Grows with the logarithm beyond k sigma: a gross error loses its influence.
  static Loss Cauchy(double k) { return {Type::kCauchy, k}; }
};

/// What a block is in the words of the field: used by reports and by the diagnosis of a rank
/// deficiency.
struct BlockLabel {
  std::string quantity;  ///< "boresight", "attitude", "gyro bias"; empty: the block's name
  std::vector<std::string> components;  ///< one per tangent coordinate: {"roll", "pitch", "yaw"}
  std::string unit;                     ///< of the reported values: "deg", "m", "mg"
  double per_si = 1.0;                  ///< reported = SI value * per_si
  double t_s = std::numeric_limits<double>::quiet_NaN();  ///< epoch; NaN for a constant
};

/// A block as the network holds it.
struct BlockRecord {
  std::string name;
  BlockKind kind;
  std::unique_ptr<double[]> value;
  bool held = false;
  BlockLabel label;
};

/// A factor as the network holds it; without factor and blocks, and inactive, once removed.
struct FactorRecord {
  std::shared_ptr<const FactorBase> factor;
  std::vector<BlockId> blocks;
  Loss loss;
  bool active = true;
  int group = 0;  ///< index into Network::groups()
  double t_s = std::numeric_limits<double>::quiet_NaN();
};

/// A dynamic network: named blocks of unknowns and the factors (edges) between them.
///
/// It describes the problem only; dn::Solve and dn::Marginals (layer solvers) work on it. Blocks
/// and factors of a user's own kind are first-class: they solve, and appear by name in every
/// report.
///
/// A copy has values, losses and states of its own, and the same ids, so that handles serve both;
/// factors, which never change, are shared.
class Network {
 public:
  Network() = default;
  Network(Network&&) = default;
  Network& operator=(Network&&) = default;
  Network(const Network& other);
  Network& operator=(const Network& other);
  ~Network() = default;

  /// Adds a rotation perturbed from the right. q is normalised. Throws InvalidInput if the name is
  /// taken, or q is not finite or has zero norm.
  Block<Rotation> AddRotation(const std::string& name, const Eigen::Quaterniond& q);

  /// Adds a rotation perturbed from the left (the boresight). Throws as AddRotation.
  Block<LeftRotation> AddLeftRotation(const std::string& name, const Eigen::Quaterniond& q);

  /// Adds N real numbers. Throws InvalidInput if the name is taken or a value is not finite.
  template <int N>
  Block<Vec<N>> AddVector(const std::string& name, const Eigen::Matrix<double, N, 1>& value) {
    return {AddStored(name, Vec<N>::kKind, value.data())};
  }

  /// Adds one real number. Throws as AddVector.
  Block<Scalar> AddScalar(const std::string& name, double value) {
    return {AddStored(name, Scalar::kKind, &value)};
  }

  /// Adds a pose: rotation and translation in one block. Throws as AddRotation and AddVector.
  Block<Pose> AddPose(const std::string& name, const Transform<double>& pose) {
    return AddBlock<Pose>(name, pose);
  }

  /// Adds a block of any kind, such as a ManifoldKind of your own: AddBlock<Direction>("north", x).
  /// The value is moved onto its manifold by a Plus of zero. Throws as AddVector, and InvalidInput
  /// for a value that Plus does not move in every direction.
  template <class Kind>
  Block<Kind> AddBlock(const std::string& name, const std::type_identity_t<ValueOf<Kind>>& value) {
    double x[Kind::kSize];
    StoreValue<Kind>(value, x);
    return {AddStored(name, KindOf<Kind>(), x)};
  }

  /// Adds a factor on blocks; a block of the wrong kind does not compile.
  template <class F, class... Kinds>
  FactorId Add(F factor, Block<Kinds>... blocks) {
    static_assert(std::is_base_of_v<FactorBase, F>,
                  "Network::Add: this is not a factor; a function is added with the noise of what "
                  "it returns: Add(function, Noise<R>::Sigma(..), blocks...)");
    if constexpr (std::is_base_of_v<FactorBase, F>) {
      static_assert(std::is_base_of_v<typename F::Self, F>,
                    "Network::Add: the first argument of the factor's base class Factor or "
                    "AutoFactor is not the factor itself");
      static_assert(
          std::is_same_v<std::tuple<Kinds...>, typename F::BlockKinds>,
          "Network::Add: the blocks do not match the factor's block table, see its header");
      return AddFactor(std::make_shared<F>(std::move(factor)), {blocks.id...});
    }
  }

  /// Adds the factor r = W f(blocks), W of the noise, Jacobians by automatic differentiation:
  ///
  ///   net.Add([=](const auto& p) { return (p - station).norm() - distance; },
  ///           dn::Noise<1>::Sigma(0.02), antenna);
  ///
  /// `function` takes one `const auto&` per block: a vector or quaternion (Eigen maps) of T, a T
  /// for a Scalar, a Transform<T> for a Pose, what View says for a kind of your own; T is double or
  /// ceres::Jet. It returns R numbers: a T, or an Eigen vector of fixed size (.eval() an
  /// expression), or a std::optional of one, empty where the model is undefined. Other shapes do
  /// not compile.
  template <class Function, int R, class... Kinds>
  FactorId Add(Function function, const Noise<R>& noise, Block<Kinds>... blocks) {
    using F = FunctionFactor<Function, R, Kinds...>;
    return AddFactor(std::make_shared<F>(std::move(function), noise), {blocks.id...});
  }

  /// The same for any number of blocks of one kind, which the function takes as one list x:
  /// x.size() and x[i].
  template <class Function, int R, class Kind>
  FactorId Add(Function function, const Noise<R>& noise, const std::vector<Block<Kind>>& blocks) {
    using F = ListFunctionFactor<Function, R, Kind>;
    std::vector<BlockId> ids;
    for (const Block<Kind> b : blocks) ids.push_back(b.id);
    return AddFactor(std::make_shared<F>(std::move(function), noise, blocks.size()), ids);
  }

  /// Adds a factor whose blocks are known at run time. Throws InvalidInput when number or kinds do
  /// not match the factor's, a block is given twice, or there is no block or residual at all.
  FactorId AddFactor(std::shared_ptr<const FactorBase> factor, const std::vector<BlockId>& blocks);

  /// Replaces the factor (same block kinds and residual size), for instance after
  /// re-preintegration.
  void ReplaceFactor(FactorId id, std::shared_ptr<const FactorBase> factor);

  /// Removes a factor for good. The ids of all others stay as they are, and its own is not used
  /// again.
  void RemoveFactor(FactorId id);

  /// Keeps a block at its value, or frees it again.
  void Hold(BlockId id, bool held = true) { block(id).held = held; }
  template <class Kind>
  void Hold(Block<Kind> b, bool held = true) {
    Hold(b.id, held);
  }

  /// Says what a factor is and its epoch (NaN: none). Throws InvalidInput unless the group has no
  /// names of rows or one per residual.
  void Tag(FactorId id, const FactorGroup& group, double t_s);
  /// The same for a group of measurements whose rows have no names.
  void Tag(FactorId id, const std::string& group, double t_s) { Tag(id, FactorGroup{group}, t_s); }

  /// Throws InvalidInput unless there are no component names or one per tangent coordinate.
  void SetLabel(BlockId id, BlockLabel label);
  /// Throws InvalidInput unless the width is positive and finite.
  void SetLoss(FactorId id, Loss loss);
  void SetActive(FactorId id, bool active) { factor_mutable(id).active = active; }

  /// Current value of a block. Throws InvalidInput for a handle of another network's block, where
  /// that shows.
  template <class Kind>
  ValueOf<Kind> Value(Block<Kind> b) const {
    CheckKind(b.id, KindOf<Kind>());
    return ValueOf<Kind>(ViewOf<Kind>(std::as_const(*this).block(b.id).value.get()));
  }

  /// Sets the value of a block; quaternions are normalised. Throws InvalidInput if not finite.
  template <class Kind>
  void SetValue(Block<Kind> b, const std::type_identity_t<ValueOf<Kind>>& value) {
    CheckKind(b.id, KindOf<Kind>());
    double x[Kind::kSize];
    StoreValue<Kind>(value, x);
    SetRaw(b.id, x);
  }
  void SetRaw(BlockId id, const double* value);

  /// Block by name; throws InvalidInput naming the nearest existing name when there is none.
  BlockId Find(const std::string& name) const;

  int num_blocks() const { return static_cast<int>(blocks_.size()); }
  /// Removed ones among them: one past the highest id.
  int num_factors() const { return static_cast<int>(factors_.size()); }
  const BlockRecord& block(BlockId id) const;
  BlockRecord& block(BlockId id);
  const FactorRecord& factor(FactorId id) const;
  /// Every group that was given to Tag; the first is that of factors without a tag.
  const std::vector<FactorGroup>& groups() const { return groups_; }
  const FactorGroup& group(FactorId id) const {
    return groups_[static_cast<std::size_t>(factor(id).group)];
  }

  /// "factor 12 (gnss position, 381000.200 s) on 'attitude/3' 'position/3'", for messages.
  std::string DescribeFactor(FactorId id) const;

  /// Sum of the tangent sizes of the blocks that are not held.
  int num_free_parameters() const;

  /// Evaluates one factor at the current values: whitened residual and, if wanted, tangent
  /// Jacobians (one matrix per block). Returns false where the model is undefined. Throws
  /// InvalidInput for a removed factor, and naming the factor where it throws.
  bool EvaluateFactor(FactorId id, Eigen::VectorXd* r,
                      std::vector<Eigen::MatrixXd>* J = nullptr) const;

  /// FactorBase::Evaluate of one factor at values x of its blocks, with r and J set to Unwritten()
  /// before. Throws as EvaluateFactor.
  bool EvaluateStored(FactorId id, double const* const* x, double* r, double** J) const;

 private:
  BlockId AddStored(const std::string& name, const BlockKind& kind, const double* value);
  FactorRecord& factor_mutable(FactorId id);
  const FactorRecord& factor_present(FactorId id) const;
  [[noreturn]] void NameException(FactorId id) const;
  void CheckKind(BlockId id, const BlockKind& kind) const;

  std::deque<BlockRecord> blocks_;
  std::vector<FactorRecord> factors_;
  std::unordered_map<std::string, BlockId> by_name_;
  std::vector<FactorGroup> groups_{FactorGroup{""}};
};

}  // namespace dn
