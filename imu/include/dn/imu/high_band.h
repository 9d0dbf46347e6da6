#pragma once

#include <dn/imu/imu_data.h>
#include <dn/imu/imu_model.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace dn {

/// The two triads of an inertial sensor, as indices.
enum ImuTriad : std::size_t { kGyroTriad, kAccelTriad };
inline constexpr std::size_t kImuTriads = 2;
inline constexpr std::array<ImuTriad, kImuTriads> kBothTriads{kGyroTriad, kAccelTriad};

/// The two highest octaves below the Nyquist frequency f, as indices: f/2 .. f and f/4 .. f/2.
enum ImuOctave : std::size_t { kTopOctave, kSecondOctave };
inline constexpr std::size_t kImuOctaves = 2;

/// Energy of a sensor's output in a band, in units of the variance that its assumed white noise and
/// the rounding of the data give one coefficient of the band.
struct BandEnergy {
  double sum = 0.0;
  double dof = 0.0;  ///< white noise of the assumed density: chi-square with so many degrees

  double Variance() const { return sum / dof; }
  BandEnergy& operator+=(const BandEnergy& other);
};

/// The high band of all axes over (t0_s, t1_s]; no degrees of freedom where there are no data.
struct HighBandWindow {
  double t0_s = 0.0;
  double t1_s = 0.0;
  std::array<std::array<std::array<BandEnergy, kImuOctaves>, 3>, kImuTriads> energy;

  const BandEnergy& At(ImuTriad triad, std::size_t axis, ImuOctave octave) const {
    return energy[triad][axis][octave];
  }
  /// Of all axes and octaves.
  BandEnergy Of(ImuTriad triad) const;
};

/// What is known of the samples of a triad.
struct TriadSamples {
  double assumed_sigma = 0.0;  ///< of a sample: white / sqrt(dt), rad/s or m/s^2
  /// Variance that the resolution of the data adds, in units of assumed_sigma^2; mean of the axes.
  double rounding = 0.0;
  double repeated_share = 0.0;  ///< of samples equal to the one before in all axes
  /// Why the high band says nothing of the sensor; empty when it does.
  std::string unusable;
};

/// The noise of an inertial sensor above the band of motion.
struct HighBand {
  std::array<TriadSamples, kImuTriads> triads;
  std::vector<HighBandWindow> windows;  ///< one after the other; energies of unusable triads are 0
};

/// How the high band is measured.
struct HighBandOptions {
  /// Short: what begins and ends does so between two windows. Data of more than 50000 windows have
  /// as many longer ones.
  double window_s = 0.2;
  /// As the data were read: means of point samples have little energy left near the Nyquist
  /// frequency, and are compared with that.
  ImuSampling sampling = ImuSampling::kMean;

  /// Throws InvalidConfig for a window that is not positive.
  void Validate() const;
};

/// The energy of the two highest octaves, by the orthogonal wavelet of Daubechies with twelve taps:
/// six vanishing moments, so that motion leaks little into them. The coefficients of white noise
/// are independent of one another, of equal variance, and those of one octave of the other's.
/// Coefficients over a gap, a bridge or an interval of another length are left out.
///
/// Within a vibration of the model the assumed noise has that of the vibration, too; samples within
/// options.window_s of its ends are left out.
///
/// A triad is unusable when more than a twentieth of its samples repeat the one before, or when its
/// resolution (found as the step of which all differences are multiples) is coarser than twice its
/// noise. Throws InvalidConfig as HighBandOptions::Validate, and as Validate of the model.
///
/// Source: Daubechies (1988), Comm. Pure Appl. Math. 41, table 1, N = 6.
HighBand MeasureHighBand(const ImuData& imu, const ImuModel& model,
                         const HighBandOptions& options = {});

}  // namespace dn
