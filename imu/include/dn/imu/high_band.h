#pragma once

#include <dn/imu/imu_data.h>
#include <dn/imu/imu_model.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace dn {

/// The two triads of an inertial sensor, as array indices.
enum ImuTriad : std::size_t { kGyroTriad, kAccelTriad };
inline constexpr std::size_t kImuTriads = 2;
inline constexpr std::array<ImuTriad, kImuTriads> kBothTriads{kGyroTriad, kAccelTriad};

/// The two highest octaves below the Nyquist frequency f, as array indices: f/2 .. f and
/// f/4 .. f/2.
enum ImuOctave : std::size_t { kTopOctave, kSecondOctave };
inline constexpr std::size_t kImuOctaves = 2;

/// Energy of a sensor's output in a frequency band. The unit is the variance that assumed white
/// noise and rounding of the data give one coefficient of the band.
struct BandEnergy {
  double sum = 0.0;
  /// White noise of the assumed density gives a chi-square with this many degrees.
  double dof = 0.0;

  double Variance() const { return sum / dof; }
  BandEnergy& operator+=(const BandEnergy& other);
};

/// Energies of the high band of all axes over (t0_s, t1_s]. Without data, the degrees of freedom
/// are 0.
struct HighBandWindow {
  double t0_s = 0.0;
  double t1_s = 0.0;
  std::array<std::array<std::array<BandEnergy, kImuOctaves>, 3>, kImuTriads> energy;

  const BandEnergy& At(ImuTriad triad, std::size_t axis, ImuOctave octave) const {
    return energy[triad][axis][octave];
  }
  /// Returns the total over all axes and octaves of a triad.
  BandEnergy Total(ImuTriad triad) const;
};

/// Properties of the samples of one triad.
struct TriadSamples {
  double assumed_sigma = 0.0;  ///< sigma of one sample: white / sqrt(dt), rad/s or m/s^2
  /// Variance that the resolution of the data adds, in units of assumed_sigma^2; mean of the axes.
  double rounding = 0.0;
  double repeated_share = 0.0;  ///< fraction of samples equal to the sample before in all axes
  /// Reason why the high band does not show the noise of the sensor; empty if it does.
  std::string unusable;
};

/// Noise of an inertial sensor at frequencies above those of the motion.
struct HighBand {
  std::array<TriadSamples, kImuTriads> triads;
  std::vector<HighBandWindow> windows;  ///< consecutive; energies of unusable triads are 0
};

/// Options of MeasureHighBand.
struct HighBandOptions {
  /// Length of a window. It should be short, so that vibrations begin and end near window limits.
  /// Data longer than 50000 windows are divided into 50000 longer windows.
  double window_s = 0.2;
  /// Sampling of the data when they were read. Means of point samples have little energy near the
  /// Nyquist frequency; the expected energies allow for that.
  ImuSampling sampling = ImuSampling::kMean;

  /// Throws InvalidConfig for a window that is not positive.
  void Validate() const;
};

/// Measures the energy of the two highest octaves with the orthogonal Daubechies wavelet of twelve
/// taps. It has six vanishing moments, so that little motion leaks into the octaves. The
/// coefficients of white noise have equal variance and are independent, also between the octaves.
/// Coefficients that overlap a gap, a bridge or an interval of unusual length are not used.
///
/// Within a vibration of the model, the vibration adds to the assumed noise. Samples within
/// options.window_s of the ends of a vibration are not used.
///
/// A triad is unusable if more than 5 % of its samples repeat the sample before. It is also
/// unusable if its resolution is coarser than twice its noise. All differences of successive values
/// are multiples of the resolution. Throws InvalidConfig as HighBandOptions::Validate and
/// Validate(ImuModel) do.
///
/// Source: Daubechies (1988), Comm. Pure Appl. Math. 41, table 1, N = 6.
HighBand MeasureHighBand(const ImuData& imu, const ImuModel& model,
                         const HighBandOptions& options = {});

}  // namespace dn
