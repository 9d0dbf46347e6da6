#pragma once

#include <dn/block.h>
#include <dn/error.h>
#include <dn/factor.h>
#include <dn/factor_group.h>
#include <dn/fixed_size.h>
#include <dn/function_factor.h>
#include <dn/manifold.h>
#include <dn/pose.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dn {

/// Number of a network in this program; 0 for a block that was not added by a network.
using NetworkId = std::uint64_t;

/// Handle of a block of a known kind. It is valid in the network that created it, and in copies of
/// that network.
template <class Kind>
struct Block {
  int id = -1;
  /// The network that created the block; 0 if the handle was made from an id, which fits any
  /// network with a block of this kind.
  NetworkId network = 0;
};

using BlockId = int;
using FactorId = int;

/// Robust loss rho(s) of the squared norm s of a factor's residual. width is in units of sigma.
struct Loss {
  enum class Type { kNone, kHuber, kCauchy, kFunction };
  /// Returns rho(s) and rho'(s) for s >= 0.
  using Function = std::function<std::array<double, 2>(double s)>;

  Type type = Type::kNone;
  double width = 1.0;
  std::shared_ptr<const Function> function = {};  ///< only for kFunction

  /// Returns the Huber loss: quadratic within k sigma, linear beyond.
  static Loss Huber(double k) { return {Type::kHuber, k}; }
  /// Returns the Cauchy loss: logarithmic beyond k sigma, so that an outlier loses its influence.
  static Loss Cauchy(double k) { return {Type::kCauchy, k}; }
  /// Returns a loss of one's own. Its second derivative must not be positive: the
  /// weight of a factor is rho' alone.
  static Loss Own(Function f) {
    return {Type::kFunction, 1.0, std::make_shared<const Function>(std::move(f))};
  }
};

/// Description of a block in the field's terms, for reports and for the diagnosis of a rank
/// deficiency.
struct BlockLabel {
  /// For example "boresight", "attitude", "gyro bias"; if empty, the block's name is used.
  std::string quantity;
  std::vector<std::string> components;  ///< one per tangent coordinate: {"roll", "pitch", "yaw"}
  std::string unit;                     ///< unit of the reported values: "deg", "m", "mg"
  double per_si = 1.0;                  ///< reported = SI value * per_si
  double t_s = std::numeric_limits<double>::quiet_NaN();  ///< epoch; NaN for a constant block
};

/// The stored numbers of a block. A constant object gives only read access to them.
class StoredValue {
 public:
  StoredValue() = default;
  explicit StoredValue(int size) : x_(new double[static_cast<std::size_t>(size)]) {}
  double* get() { return x_.get(); }
  const double* get() const { return x_.get(); }
  double& operator[](int i) { return x_[static_cast<std::size_t>(i)]; }
  double operator[](int i) const { return x_[static_cast<std::size_t>(i)]; }

 private:
  std::unique_ptr<double[]> x_;
};

/// A block as stored in the network.
struct BlockRecord {
  std::string name;
  BlockKind kind;
  StoredValue value;
  bool held = false;
  BlockLabel label;
  NetworkId network = 0;  ///< the network that created the block; see Block
  std::shared_ptr<const void> owner =
      {};  ///< keeps the functions of the kind alive, if they need it

  /// Returns true for a removed block. It is constant and its sizes are 0.
  bool removed() const { return kind.stored_size == 0; }
};

/// A factor as stored in the network. A removed factor is inactive and has neither factor nor
/// blocks.
struct FactorRecord {
  std::shared_ptr<const FactorBase> factor;
  std::vector<BlockId> blocks;
  Loss loss;
  bool active = true;
  int group = 0;  ///< index into Network::groups()
  double t_s = std::numeric_limits<double>::quiet_NaN();
};

/// Throws InvalidInput naming the block unless it has this kind and was created by this network (0:
/// any). `name`, `kind` and `network` are those of the block.
void CheckHandle(const std::string& name, const BlockKind& kind, NetworkId network,
                 const BlockKind& expected_kind, NetworkId expected_network);

namespace core_internal {

/// Takes any argument of a call that does not fit.
struct AnyArgument {
  template <class... Arguments>
  AnyArgument(const Arguments&...) {}  // NOLINT(google-explicit-constructor)
};

template <int R>
void TakeNoiseOrBlock(const Noise<R>&);
template <class Kind>
void TakeNoiseOrBlock(const Block<Kind>&);
template <class Kind>
void TakeNoiseOrBlock(const std::vector<Block<Kind>>&);

/// Arguments that Network::Add takes after a factor or a function.
template <class Argument>
concept NoiseOrBlock = requires(const Argument& argument) {
  TakeNoiseOrBlock(argument);
};

/// Factors whose blocks are known at compile time.
template <class F>
concept FactorOfKinds = requires {
  typename F::Self;
  typename F::BlockKinds;
};

}  // namespace core_internal

/// A dynamic network: named blocks of unknowns and the factors (edges) between them.
///
/// It only describes the problem; dn::Solve and dn::Marginals (layer solvers) operate on it. Blocks
/// and factors of a user's own kind have equal rights: they are estimated, and appear by name in
/// every report.
///
/// A copy has its own values, losses and states, and the same ids, so that handles work for both.
/// Handles of blocks that are added to one of them later are refused by the other. Factors never
/// change and are shared.
class Network {
 public:
  Network() = default;
  /// The network that was moved from is empty.
  Network(Network&& other) noexcept;
  Network& operator=(Network&& other) noexcept;
  Network(const Network& other);
  Network& operator=(const Network& other);
  ~Network() = default;

  /// Adds a rotation perturbed from the right; q is normalised. Throws InvalidInput if the name is
  /// taken, or if q is not finite or has zero norm.
  Block<Rotation> AddRotation(const std::string& name, const Eigen::Quaterniond& q);

  /// Adds a rotation perturbed from the left (the boresight). Throws as AddRotation does.
  Block<LeftRotation> AddLeftRotation(const std::string& name, const Eigen::Quaterniond& q);

  /// Adds N real numbers. Throws InvalidInput if the name is taken or a value is not finite.
  template <int N>
  Block<Vec<N>> AddVector(const std::string& name, const Eigen::Matrix<double, N, 1>& value) {
    return Handle<Vec<N>>(AddStored(name, Vec<N>::kKind, value.data()));
  }
  template <int N, class Derived>
  Block<Vec<N>> AddVector(const std::string& name, const Eigen::MatrixBase<Derived>& value) {
    return AddVector<N>(
        name, core_internal::FixedSize<N, 1>(value, "network: value of block '" + name + "'"));
  }

  /// Adds one real number. Throws as AddVector does.
  Block<Scalar> AddScalar(const std::string& name, double value) {
    return Handle<Scalar>(AddStored(name, Scalar::kKind, &value));
  }

  /// Adds a pose: rotation and translation in one block. Throws as AddRotation and AddVector do.
  Block<Pose> AddPose(const std::string& name, const Transform<double>& pose) {
    return AddBlock<Pose>(name, pose);
  }

  /// Adds a block of any kind, such as a user's own ManifoldKind: AddBlock<Direction>("north", x).
  /// The value is projected onto its manifold by a Plus of zero. Throws as AddVector does, and
  /// InvalidInput if Plus cannot move the value in every direction. The first block of a user's own
  /// kind is also checked by CheckManifold, so that a wrong Minus or PlusJacobian throws here.
  template <class Kind>
  requires core_internal::CompleteKind<Kind> Block<Kind> AddBlock(
      const std::string& name, const std::type_identity_t<BlockValue<Kind>>& value) {
    double x[Kind::kSize];
    StoreValue<Kind>(value, x);
    return Handle<Kind>(AddStored(name, MakeBlockKind<Kind>(), x));
  }
  /// Explains, as a compiler error, what the kind lacks.
  template <class Kind>
  requires(!core_internal::CompleteKind<Kind>) Block<Kind> AddBlock(
      const std::string&, const core_internal::AnyArgument&) {
    MakeBlockKind<Kind>();
    return {};
  }

  /// Adds a block whose kind is known only at run time, such as VectorKind(n). `owner` is kept as
  /// long as the block or a copy of it exists; pass it if it owns the functions of the kind. Throws
  /// as AddBlock<Kind> does, and InvalidInput if sizes do not fit.
  BlockId AddBlock(const std::string& name, const BlockKind& kind, const Eigen::VectorXd& value,
                   std::shared_ptr<const void> owner = {});

  /// Removes a block, and every factor on it, permanently. The ids of all others stay valid; the
  /// removed ids are not used again, but the name is free.
  void RemoveBlock(BlockId id) { RemoveBlocks({id}); }
  template <class Kind>
  void RemoveBlock(Block<Kind> b) {
    RemoveBlock(Id(b));
  }
  /// Does what RemoveBlock does for several blocks, in one pass over the factors.
  void RemoveBlocks(const std::vector<BlockId>& ids);

  /// The blocks and factors that Append added.
  class Appended {
   public:
    /// Returns the id in this network of a block of the appended one.
    BlockId Id(BlockId other) const;
    /// Returns the handle in this network of a block of the appended one. Throws InvalidInput for a
    /// handle of a third network.
    template <class Kind>
    Block<Kind> Handle(Block<Kind> other) const {
      return {Id(other.id), CheckedNetwork(other.id, other.network)};
    }
    /// Returns the id in this network of a factor of the appended one.
    FactorId Factor(FactorId other) const;

   private:
    friend class Network;
    NetworkId CheckedNetwork(BlockId other, NetworkId network) const;

    std::vector<BlockId> blocks_;                            // -1 for a removed block
    std::vector<std::pair<NetworkId, NetworkId>> networks_;  // of each block, there and here
    std::vector<FactorId> factors_;
  };

  /// Adds all blocks and factors of another network; the names of its blocks get the prefix. A
  /// block named in `shared` keeps its name and is the block of that name in this network. It has
  /// the value and state that it has here, and is added if this network does not have it yet. Two
  /// flights with one boresight:
  ///
  ///   dn::Network both;
  ///   both.Append(monday.net, "monday/", {"boresight"});
  ///   both.Append(tuesday.net, "tuesday/", {"boresight"});
  ///
  /// A prior of a shared block then counts once per appended network. Throws InvalidInput, and adds
  /// nothing, if a name is taken, if a shared name does not exist in `other`, or if its kind
  /// differs.
  Appended Append(const Network& other, const std::string& prefix,
                  const std::vector<std::string>& shared = {});

  /// Adds a factor on blocks; a block of the wrong kind is a compile error. If the kinds of the
  /// factor are known only at run time (DynamicFactor), it throws InvalidInput as AddFactor does.
  template <class F, class... Kinds>
  FactorId Add(F factor, Block<Kinds>... blocks) {
    constexpr bool kIsFactor = std::is_base_of_v<FactorBase, F>;
    static_assert(kIsFactor,
                  "dn: the first argument of Network::Add is not a factor; a function needs the "
                  "noise of its result: Add(function, Noise<R>::Sigma(..), blocks...)");
    if constexpr (core_internal::FactorOfKinds<F>) {
      constexpr bool kIsSelf = std::is_base_of_v<typename F::Self, F>;
      static_assert(kIsSelf,
                    "dn: the first template argument of the base class Factor or AutoFactor must "
                    "be the class of the factor itself");
      constexpr bool kSameKinds = std::is_same_v<std::tuple<Kinds...>, typename F::BlockKinds>;
      static_assert(kSameKinds,
                    "dn: the blocks do not match the factor's block table, see its header");
      if constexpr (kIsSelf && kSameKinds) {
        return AddFactor(std::make_shared<F>(std::move(factor)), {Id(blocks)...});
      }
    } else if constexpr (kIsFactor) {
      return AddFactor(std::make_shared<F>(std::move(factor)), {Id(blocks)...});
    }
    return -1;
  }

  /// Adds the factor r = W f(blocks), where W comes from the noise and the Jacobians from automatic
  /// differentiation:
  ///
  ///   net.Add([=](const auto& p) { return (p - station).norm() - distance; },
  ///           dn::Noise<1>::Sigma(0.02), antenna);
  ///
  /// `function` takes one `const auto&` per block. It is a vector or quaternion (Eigen map) of T.
  /// For a Scalar it is a T, for a Pose a Transform<T>, for a user's own kind its View. T is double
  /// or ceres::Jet. The function returns R residuals: a T, an Eigen vector of fixed size (end an
  /// expression with .eval()), or a std::optional of one of these. An empty optional means that the
  /// model is undefined. Other shapes do not compile.
  template <class Function, int R, class... Kinds>
  FactorId Add(Function function, const Noise<R>& noise, Block<Kinds>... blocks) {
    constexpr bool kIsFunction = !std::is_base_of_v<FactorBase, Function>;
    static_assert(kIsFunction,
                  "dn: a factor class whitens its own residual: Add(factor, blocks...) takes no "
                  "noise");
    static_assert(sizeof...(Kinds) > 0, "dn: a factor needs at least one block");
    if constexpr (kIsFunction && sizeof...(Kinds) > 0) {
      using Check = core_internal::CheckFunction<Function, Kinds...>;
      core_internal::ExpectFit<Check::Fit(), Check::template Size<R>(), R>();
      if constexpr (Check::template kGood<R>) {
        using F = FunctionFactor<Function, R, Kinds...>;
        return AddFactor(std::make_shared<F>(std::move(function), noise), {Id(blocks)...});
      }
    }
    return -1;
  }

  /// Adds the factor of a function of any number of blocks of one kind. The function takes the
  /// blocks as one list x with x.size() and x[i].
  template <class Function, int R, class Kind>
  FactorId Add(Function function, const Noise<R>& noise, const std::vector<Block<Kind>>& blocks) {
    using Check = core_internal::CheckListFunction<Function, Kind>;
    core_internal::ExpectFit<Check::Fit(), Check::template Size<R>(), R>();
    if constexpr (Check::template kGood<R>) {
      using F = ListFunctionFactor<Function, R, Kind>;
      std::vector<BlockId> ids;
      for (const Block<Kind> b : blocks) ids.push_back(Id(b));
      return AddFactor(std::make_shared<F>(std::move(function), noise, blocks.size()), ids);
    }
    return -1;
  }

  /// Explains, as a compiler error, that an argument after the first is neither noise nor block.
  template <class F, class... Arguments>
  requires(!(core_internal::NoiseOrBlock<Arguments> && ...)) FactorId
      Add(const F&, const Arguments&...) {
    static_assert((core_internal::NoiseOrBlock<Arguments> && ...),
                  "dn: Network::Add takes a factor and its blocks, or a function, its noise and "
                  "its blocks: noise is Noise<R>::Sigma(..) or Covariance(..), and a block is "
                  "the handle that AddVector or Find<Kind> returns");
    return -1;
  }

  /// Adds a factor whose blocks are known at run time. Throws InvalidInput if the number or kinds
  /// of the blocks do not match the factor, or if a block is given twice. Also throws without any
  /// block or residual.
  FactorId AddFactor(std::shared_ptr<const FactorBase> factor, const std::vector<BlockId>& blocks);

  /// Replaces a factor by one with the same block kinds and residual size, for instance after
  /// repreintegration. Throws InvalidInput for other kinds or sizes.
  void ReplaceFactor(FactorId id, std::shared_ptr<const FactorBase> factor);

  /// Removes a factor permanently. The ids of all other factors stay valid, and the removed id is
  /// not used again.
  void RemoveFactor(FactorId id);

  /// Sets a block constant at its value, or makes it an unknown again.
  void Hold(BlockId id, bool held = true) { block_present(id).held = held; }
  template <class Kind>
  void Hold(Block<Kind> b, bool held = true) {
    Hold(Id(b), held);
  }

  /// Sets the group of a factor and its epoch (NaN: no epoch). Throws InvalidInput unless the group
  /// has either no row names or one per residual.
  void Tag(FactorId id, const FactorGroup& group, double t_s);
  /// Sets the group of a factor by its name, for measurements without row names.
  void Tag(FactorId id, const std::string& group, double t_s) { Tag(id, FactorGroup{group}, t_s); }

  /// Sets the label of a block. Throws InvalidInput unless it has either no component names or one
  /// per tangent coordinate.
  void SetLabel(BlockId id, BlockLabel label);
  /// Sets the robust loss of a factor. Throws InvalidInput unless the width is positive and finite.
  void SetLoss(FactorId id, Loss loss);
  void SetActive(FactorId id, bool active) { factor_mutable(id).active = active; }

  /// Returns the current value of a block. Throws InvalidInput if the handle belongs to another
  /// network, or does not match a block of this network.
  template <class Kind>
  BlockValue<Kind> Value(Block<Kind> b) const {
    return BlockValue<Kind>(MakeView<Kind>(std::as_const(*this).block(Id(b)).value.get()));
  }

  /// Sets the value of a block; quaternions are normalised. Throws InvalidInput if it is not
  /// finite.
  template <class Kind>
  void SetValue(Block<Kind> b, const std::type_identity_t<BlockValue<Kind>>& value) {
    double x[Kind::kSize];
    StoreValue<Kind>(value, x);
    SetRaw(Id(b), x);
  }
  template <class Kind, class Derived>
  requires(BlockValue<Kind>::ColsAtCompileTime ==
           1) void SetValue(Block<Kind> b, const Eigen::MatrixBase<Derived>& value) {
    SetValue(b, core_internal::FixedSize<Kind::kSize, 1>(
                    value, "network: value of block '" + block(Id(b)).name + "'"));
  }
  void SetRaw(BlockId id, const double* value);

  /// Returns or sets the stored numbers of a block whose kind is known only at run time.
  Eigen::VectorXd Value(BlockId id) const;
  void SetValue(BlockId id, const Eigen::VectorXd& value);

  /// Returns the block with this name. Throws InvalidInput naming the nearest existing name if
  /// there is no such block.
  BlockId Find(const std::string& name) const;
  /// Returns the handle of the block with this name; also throws if the block has another kind.
  template <class Kind>
  Block<Kind> Find(const std::string& name) const {
    const Block<Kind> found{Find(name)};
    return Handle<Kind>(Id(found));
  }

  /// Returns the id of a block. Throws InvalidInput if the handle belongs to another network, or
  /// does not match a block of this network.
  template <class Kind>
  BlockId Id(Block<Kind> b) const {
    const BlockRecord& record = block(b.id);
    CheckHandle(record.name, record.kind, record.network, MakeBlockKind<Kind>(), b.network);
    return b.id;
  }

  int num_blocks() const { return static_cast<int>(blocks_.size()); }
  /// Returns the highest factor id plus one; removed factors are included.
  int num_factors() const { return static_cast<int>(factors_.size()); }
  const BlockRecord& block(BlockId id) const;
  BlockRecord& block(BlockId id);
  const FactorRecord& factor(FactorId id) const;
  /// Returns every group that was given to Tag; the first is that of factors without a tag.
  const std::vector<FactorGroup>& groups() const { return groups_; }
  const FactorGroup& group(FactorId id) const {
    return groups_[static_cast<std::size_t>(factor(id).group)];
  }

  /// Returns text for messages, such as "factor 12 (gnss position, 381000.200 s) on 'attitude/3'
  /// 'position/3'".
  std::string DescribeFactor(FactorId id) const;

  /// Returns the sum of the tangent sizes of the blocks that are not constant.
  int num_free_parameters() const;

  /// Evaluates one factor at the current values: whitened residual and, if J is not null, tangent
  /// Jacobians (one matrix per block). Returns false if the model is undefined. Throws InvalidInput
  /// for a removed factor, and InvalidInput naming the factor if the factor throws.
  bool EvaluateFactor(FactorId id, Eigen::VectorXd* r,
                      std::vector<Eigen::MatrixXd>* J = nullptr) const;

  /// Calls dn::EvaluateStored of one factor at the values x of its blocks. Throws as EvaluateFactor
  /// does.
  bool EvaluateStored(FactorId id, double const* const* x, double* r, double** J) const;

 private:
  void Clear() noexcept;
  void CheckNewKind(const BlockRecord& record);
  BlockId AddStored(const std::string& name, const BlockKind& kind, const double* value,
                    std::shared_ptr<const void> owner = {});
  /// Returns the ids that the blocks of `other` get, -1 for those to add; see Append.
  std::vector<BlockId> FindShared(const Network& other, const std::string& prefix,
                                  const std::vector<std::string>& shared) const;
  BlockRecord& block_present(BlockId id);
  FactorRecord& factor_mutable(FactorId id);
  const FactorRecord& factor_present(FactorId id) const;
  [[noreturn]] void NameException(FactorId id) const;
  template <class Kind>
  Block<Kind> Handle(BlockId id) const {
    return {id, block(id).network};
  }

  NetworkId id_ = 0;                                  // 0 until the first block is added
  std::vector<std::unique_ptr<BlockRecord>> blocks_;  // records stay at their addresses
  std::vector<FactorRecord> factors_;
  std::unordered_map<std::string, BlockId> by_name_;
  std::vector<FactorGroup> groups_{FactorGroup{""}};
  std::vector<const ManifoldFunctions*> checked_;  // kinds that passed CheckManifold
};

}  // namespace dn
