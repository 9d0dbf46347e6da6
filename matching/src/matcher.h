#pragma once

#include <dn/matching/match.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "coarse_alignment.h"
#include "height_raster.h"
#include "match_cells.h"
#include "patch_surface.h"
#include "patches.h"
#include "register_patches.h"
#include "strip_sample.h"

namespace dn::matching_internal {

inline constexpr double kRasterCell_gsd = 3.0;  ///< of the finest rasters
inline constexpr int kRootCells = 32;           ///< side of the largest cells, in such cells
inline constexpr double kToleranceCells = 2.5;  ///< of pairs that agree with an alignment

/// A place with a unique shift between the rasters.
struct MatchedPlace {
  Eigen::Vector2d centre_en_m;
  Eigen::Vector3d shift_m;  ///< of a to b
};

/// A registered cell of two strips and its pair.
struct RegisteredCell {
  Registration registration;
  MatchedPair pair;
};

/// A registered smooth cell of two strips and its pair.
struct RegisteredSurface {
  SurfaceRegistration registration;
  MatchedSurface surface;
};

/// The registered cells of two strips.
struct RegisteredCells {
  std::vector<RegisteredCell> cells;
  std::vector<RegisteredSurface> surfaces;

  void Append(RegisteredCells more);
};

/// Pieces of a raster that are compared with another raster.
struct Pieces {
  int half = 0;         ///< cells on each side of the centre
  int search = 0;       ///< search radius in cells
  double places = 0.0;  ///< approximate number per strip pair
};

/// Finds the pairs of all strips of a source. What the strips have in common, such as a boresight,
/// is up to the derived class.
class Matcher {
 public:
  Matcher(MatchSource* source, const MatchOptions& options) : source_(*source), options_(options) {}
  virtual ~Matcher() = default;

  /// Runs the levels from coarse to fine; changes the alignment of the source.
  const MatchResult& BringTogether();

  /// Brings the strips together, then matches all of them. Call it once.
  MatchResult Run();

 protected:
  /// Returns the radius of the coarsest search, m.
  virtual double FirstSearch() const = 0;
  /// Aligns the strips by the pairs that agree within the tolerance.
  virtual AlignmentFit Align(const std::vector<CoarsePair>& pairs, double tolerance_m) = 0;
  virtual bool HasBoresight() const { return false; }
  virtual Eigen::Vector3d Boresight() const { return Eigen::Vector3d::Zero(); }
  /// Returns how often a few cells correct the boresight at most, before all are matched.
  virtual int MostPilots() const { return 1; }
  /// Corrects the pairs for the range offset of plants; returns whether it did.
  virtual bool RemovePlantOffset(MatchResult* /*result*/) const { return false; }
  /// Calls `work` with the initial alignment.
  virtual void AsGiven(const std::function<void()>& work) = 0;
  /// Returns whether smooth cells become surfaces.
  virtual bool TakesSurfaces() const { return false; }
  /// Returns whether two strips are matched with each other.
  virtual bool Compares(std::size_t /*i*/, std::size_t /*j*/) const { return true; }
  /// Returns whether strips without any overlap are an error.
  virtual bool MustOverlap() const { return true; }

  const MatchOptions& options() const { return options_; }
  /// Returns how far boresights within the search angle move two strips apart, m. Opposite strips,
  /// or two scanners, move apart by twice the shift that the angle causes at the mean range. Half
  /// of this shift is added for the other angles.
  double ShiftByAngles() const;

 private:
  /// Returns the side of the cells of the finest rasters, m.
  double BaseCell() const;

  void Tell(const std::string& stage, const std::string& done = "") const;

  std::string PairName(std::size_t i, std::size_t j) const;

  [[noreturn]] void FailNoOverlap() const;

  double ChooseGsd() const;

  void ReadSamples();

  void PlaceSamples();

  /// Runs one level of the alignment; returns the remaining search radius.
  double RunLevel(double search_m, const Pieces& pieces);

  void FindCoarse(std::size_t i, std::size_t j, const Pieces& pieces, MatchLevel* level,
                  std::vector<CoarsePair>* pairs);

  static std::vector<Eigen::Vector2i> Centres(const HeightRaster& raster, double places);

  void AddCoarse(std::size_t i, std::size_t j, const HeightRaster& raster_a,
                 const HeightRaster& raster_b, const Eigen::Vector2i& place,
                 const Eigen::Vector3d& shift_m, std::vector<CoarsePair>* pairs) const;

  void MatchStripPair(std::size_t i, std::size_t j, std::size_t most_roots);

  /// Finds the shifts between the rasters at the places of a regular grid.
  std::vector<MatchedPlace> FindPlaces(const HeightRaster& a, const HeightRaster& b,
                                       StripPairMatch* match) const;

  /// Returns the median shift of the places nearest to a cell.
  static Eigen::Vector3d StartShift(const GroundCell& cell,
                                    const std::vector<MatchedPlace>& places);

  /// Returns the largest number of points per square ground sampling distance, of all beams.
  double MostPoints() const;

  double KeepShare(std::size_t strip) const;

  /// Registers the cells until there are enough pairs.
  RegisteredCells RegisterRoots(const StripPairMatch& match, const std::vector<GroundCell>& roots,
                                const std::vector<MatchedPlace>& places) const;

  void RegisterSome(const StripPairMatch& match, const std::vector<GroundCell>& roots,
                    const std::vector<MatchedPlace>& places, RegisteredCells* work) const;

  RegisteredCells RegisterRoot(std::size_t i, const GroundCell& root,
                               const Eigen::Vector3d& start_m, const CellPoints& in_a,
                               const CellPoints& in_b) const;

  /// Registers every beam of the first strip with a beam of the second one. The difference of their
  /// numbers varies from cell to cell.
  RegisteredCells RegisterBeams(std::size_t i, const GroundCell& root,
                                const Eigen::Vector3d& start_m, const CellPoints& in_a,
                                const CellPoints& in_b) const;

  [[noreturn]] void FailWithoutBeams() const;

  RegisteredCells RegisterPoints(std::size_t i, const GroundCell& root,
                                 const Eigen::Vector3d& start_m, const CellPoints& in_a,
                                 const CellPoints& in_b) const;

  /// Returns the pair nearest to a place of strip a, for a shift of a to b.
  LidarPair MakePair(std::size_t i, const Eigen::Vector2d& at_en_m, const Eigen::Vector3d& shift_m,
                     const CellPoints& in_a, const CellPoints& in_b, const PatchSurface& b) const;

  /// Returns the mean of Registration::variance_ratio, at least 1.
  double VarianceFactor() const;
  double SurfaceVarianceFactor() const;

  Swath MakeSwath(std::size_t strip) const;

  /// Matches all strips and aligns them by the pairs. Returns how far the boresight turned, rad.
  /// most_roots: number of largest cells of a strip pair.
  double MatchAll(std::size_t most_roots);

  void Finish();

  /// Adds the pairs whose registration is accurate enough. A cell whose horizontal shift is too
  /// uncertain becomes a surface.
  void TakeDetermined(std::size_t k);
  void TakeSurfaces(std::size_t k);
  void AddSurface(MatchedSurface surface, StripPairMatch* match) const;

  /// Keeps the pairs that agree with their neighbours. The strips must be aligned first; otherwise
  /// the effect of the boresight, which varies with the position, would count as disagreement.
  void KeepAgreeing(StripPairMatch* match) const;
  void KeepAgreeingSurfaces(StripPairMatch* match) const;

  void AlignAll();

  /// Sets the positions and differences of the pairs before and after the alignment.
  void PlacePairs();

  Eigen::Vector3d Apart(const StripPairMatch& match, const LidarPair& pair) const;
  double SurfacesApart(const StripPairMatch& match, const MatchedSurface& surface) const;

  MatchSource& source_;
  const MatchOptions& options_;
  std::vector<StripSample> samples_;
  std::vector<RegisteredCells> registered_;  // one per entry of result_.strip_pairs
  MatchResult result_;
};

}  // namespace dn::matching_internal
