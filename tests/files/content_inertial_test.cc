// Inertial data as loggers, phones and autopilots write them: names, units and vectors.
#include <dn/files/file_content.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "inertial_rows.h"

namespace dn::files_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

using RowOrder = std::function<Row(double t, const Row& w, const Row& f)>;

/// Returns a row with the time in another unit before rates and forces.
RowOrder TimeRatesForces(double time_factor, double rate_factor = 1.0, double force_factor = 1.0) {
  return [=](double t, const Row& w, const Row& f) {
    return Plus(Plus({time_factor * (381000 + t)}, Times(w, rate_factor)), Times(f, force_factor));
  };
}

TEST(ContentInertial, NamesDecideAgainstAPosition) {
  for (const Row& field : {Row{0.2, 0.1, 0.4}, Row{0, 0, 0}, Row{22, 5, -43}}) {
    for (const double motion : {0.0, 0.01, 1.0}) {
      SCOPED_TRACE(fmt::format("{} {}", field[0], motion));
      const FileContent content = Inspect(
          "SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Mag_X,Mag_Y,Mag_Z\n" +
          Inertial([&](double t, const Row& w, const Row& f) {
            const Row force{motion * f[0], motion * f[1], -9.8 + motion * (f[2] + 9.8)};
            return Plus(Plus(Plus({std::round(1e6 * (381000 + t))}, force), Times(w, motion)),
                        field);
          }));
      EXPECT_EQ(content.kind, FileKind::kImu) << content.why;
      EXPECT_THAT(content.columns, ElementsAre("t_us", "fx", "fy", "fz", "wx", "wy", "wz"));
    }
  }
}

TEST(ContentInertial, ACountOfRowsIsNoTime) {
  for (const char* count : {"PacketCounter", "packet counter", "Sequence", "Index"}) {
    SCOPED_TRACE(count);
    const FileContent content = Inspect(std::string(count) + ",AccX,AccY,AccZ,GyrX,GyrY,GyrZ\n" +
                                        Inertial([](double t, const Row& w, const Row& f) {
                                          return Plus(Plus({std::round(50 * t)}, f), w);
                                        }));
    EXPECT_EQ(content.kind, FileKind::kUnknown);
    EXPECT_THAT(content.why, HasSubstr(fmt::format("'{}' counts rows", count)));
  }
}

/// Returns rows at 1 Hz.
std::string EachSecond(const std::function<Row(double t)>& row) {
  std::string text;
  for (int i = 0; i < 200; ++i) text += Join(row(381000 + i), ",");
  return text;
}

TEST(ContentInertial, OtherQuantitiesAreNoPosition) {
  const std::string battery = EachSecond([](double t) {
    return Row{t, 12.5 + 0.1 * std::sin(0.1 * t), 5.2 + 0.5 * std::cos(t), 87.0};
  });
  for (const char* header : {"timestamp,voltage,current,remaining\n", "Time (s),U,I,Charge\n",
                             "time,temp 1,temp 2,humidity\n", "t,x,y,z\n"}) {
    SCOPED_TRACE(header);
    EXPECT_EQ(Inspect(header + battery).kind, FileKind::kUnknown);
  }
  const auto constant = [](double t) { return Row{t, 4, 12, 46.5, 6.5 + 1e-4 * t, 500}; };
  EXPECT_EQ(Inspect(EachSecond(constant)).kind, FileKind::kUnknown);
  const std::string position = EachSecond([](double t) {
    return Row{t, 46.5 + 1e-4 * (t - 381000), 6.5 + 1e-4 * (t - 381000), 500};
  });
  for (const char* header : {"", "t,B,L,H\n", "t,latDeg,lonDeg,hEllM\n", "Zeit,Lat.,Lon.,h\n"}) {
    SCOPED_TRACE(header);
    EXPECT_EQ(Inspect(header + position).kind, FileKind::kGnss);
  }
}

TEST(ContentInertial, OneSensorAloneIsNamed) {
  struct Case {
    const char *header, *file, *why;
    bool rates;
  };
  const std::array<Case, 9> cases{
      {{"time,acc_x,acc_y,acc_z\n", "a.csv", "only accelerations: join both files", false},
       {"time,gyro_x,gyro_y,gyro_z\n", "a.csv", "only rates: join both files", true},
       {"timestamp,AccelX,AccelY,AccelZ\n", "1.txt", "only accelerations: join", false},
       {"Time,rotationRateX,rotationRateY,rotationRateZ\n", "1.txt", "only rates: join", true},
       {"\"Time (s)\",\"X (m/s^2)\",\"Y (m/s^2)\",\"Z (m/s^2)\"\n", "b.csv", "only acceler", false},
       {"\"Time (s)\",\"X (rad/s)\",\"Y (rad/s)\",\"Z (rad/s)\"\n", "b.csv", "only rates", true},
       {"seconds_elapsed,z,y,x\n", "Accelerometer.csv", "only accelerations", false},
       {"seconds_elapsed,z,y,x\n", "TotalAcceleration.csv", "only accelerations", false},
       {"seconds_elapsed,z,y,x\n", "Gyroscope.csv", "only rates", true}}};
  for (const Case& each : cases) {
    for (const double start_s : {0.0, 381000.0, 1.6952897e9}) {
      SCOPED_TRACE(fmt::format("{} {}", each.header, start_s));
      const std::string rows = Inertial([&](double t, const Row& w, const Row& f) {
        return Plus({start_s + t}, each.rates ? w : f);
      });
      const FileContent content = Inspect(each.header + rows, each.file);
      EXPECT_EQ(content.kind, FileKind::kUnknown);
      EXPECT_THAT(content.why, HasSubstr(each.why));
    }
  }
}

TEST(ContentInertial, NumberedAxes) {
  const std::string rows = Inertial([](double t, const Row& w, const Row& f) {
    return Plus(Plus(Plus({1e6 * t}, w), Plus({20000, 0}, f)), {20000, 0, 0, 1, 1});
  });
  const std::string tail = ",integral_dt,clipping,gyro_clipping,accel_count,gyro_count\n";
  const char* const kPx4 =
      "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_dt,accelerometer_timestamp_relative,"
      "accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2]";
  for (const char* header :
       {kPx4, "timestamp,gyro.0,gyro.1,gyro.2,gyro_dt,relative,accel.0,accel.1,accel.2",
        "timestamp,gyro_1,gyro_2,gyro_3,gyro_dt,relative,accel_1,accel_2,accel_3",
        "timestamp,gyro0,gyro1,gyro2,gyro_dt,relative,acc0,acc1,acc2",
        "timestamp,gyro.x,gyro.y,gyro.z,gyro_dt,relative,acc.x,acc.y,acc.z"}) {
    SCOPED_TRACE(header);
    const FileContent content = Inspect(std::string(header).append(tail).append(rows));
    EXPECT_EQ(content.kind, FileKind::kImu) << content.why;
    EXPECT_THAT(content.columns,
                ElementsAre("t_us", "wx", "wy", "wz", "skip", "skip", "fx", "fy", "fz"));
    EXPECT_FALSE(content.forces_in_g || content.rates_in_deg);
  }
  // Without names, a constant vector of length 1 is not gravity.
  EXPECT_THAT(Inspect(rows).columns,
              ElementsAre("t_us", "wx", "wy", "wz", "skip", "skip", "fx", "fy", "fz"));
}

TEST(ContentInertial, MoreNames) {
  const char* const kMscl =
      "Time,a:scaledGyroX,a:scaledGyroY,a:scaledGyroZ,a:scaledAccelX,a:scaledAccelY,"
      "a:scaledAccelZ\n";
  const char* const kCoreMotion =
      "loggingTime,gyroRotationX(rad/s),gyroRotationY(rad/s),gyroRotationZ(rad/s),"
      "accelerometerAccelerationX,accelerometerAccelerationY,accelerometerAccelerationZ\n";
  for (const char* header :
       {"t,rotationRateX,rotationRateY,rotationRateZ,accelerationX,accelerationY,accelerationZ\n",
        "t,IMUGyrX,IMUGyrY,IMUGyrZ,IMUAccX,IMUAccY,IMUAccZ\n",
        "t,xGyro,yGyro,zGyro,xAcc,yAcc,zAcc\n", "t,xgyro,ygyro,zgyro,xacc,yacc,zacc\n",
        "t,BodyRateX,BodyRateY,BodyRateZ,BodyAccX,BodyAccY,BodyAccZ\n",
        "t,AngRateX,AngRateY,AngRateZ,AccelX,AccelY,AccelZ\n",
        "t,angratex,angratey,angratez,forcex,forcey,forcez\n", kMscl, kCoreMotion,
        "t,gyro1_x,gyro1_y,gyro1_z,acc1_x,acc1_y,acc1_z\n",
        "TIME_S,GYR_X_RAD_S,GYR_Y_RAD_S,GYR_Z_RAD_S,ACC_X_MPS2,ACC_Y_MPS2,ACC_Z_MPS2\n"}) {
    SCOPED_TRACE(header);
    const FileContent content = Inspect(header + Inertial(TimeRatesForces(1.0)));
    EXPECT_EQ(content.kind, FileKind::kImu) << content.why;
    EXPECT_THAT(content.columns, ElementsAre("t", "wx", "wy", "wz", "fx", "fy", "fz"));
    EXPECT_THAT(content.why, Not(HasSubstr("in columns")));  // by name, not by trial
  }
  // Names with capitals, and quantities that must not be taken for others.
  const FileContent calibrated = Inspect(
      "TimeStartup,TimeGps,UncompAccelX,UncompAccelY,UncompAccelZ,AccelX,AccelY,AccelZ,GyroX,"
      "GyroY,GyroZ\n" +
      Inertial([](double t, const Row& w, const Row& f) {
        return Plus(Plus(Plus({1e9 * t, 1e9 * (1.3789e9 + t)}, f), f), w);
      }));
  EXPECT_THAT(calibrated.columns, ElementsAre("skip", "t_ns", "skip", "skip", "skip", "fx", "fy",
                                              "fz", "wx", "wy", "wz"));
  const FileContent free =
      Inspect("t,FreeAcc_X,FreeAcc_Y,FreeAcc_Z,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\n" +
              Inertial([](double t, const Row& w, const Row& f) {
                return Plus(Plus({381000 + t, f[0], f[1], f[2] + 9.81}, f), w);
              }));
  EXPECT_THAT(free.columns,
              ElementsAre("t", "skip", "skip", "skip", "fx", "fy", "fz", "wx", "wy", "wz"));
}

TEST(ContentInertial, UnitsInNames) {
  struct Case {
    const char *rate, *force;
    double rate_size, force_size;
    bool deg, g;
  };
  constexpr double kG = 9.80665, kDeg = std::numbers::pi / 180.0;
  const std::array<Case, 10> cases{
      {{"(mrad/s)", "(m/s^2)", 1e-3, 1.0, false, false},
       {"[mrad s^-1]", "[mg]", 1e-3, 1e-3 * kG, false, false},
       {"(deg/h)", "(m/s2)", kDeg / 3600, 1.0, false, false},
       {"<dps>", "<g>", kDeg, kG, true, true},
       {"[\xC2\xB0/s]", "[m/s\xC2\xB2]", kDeg, 1.0, true, false},
       {"(\xC2\xB0.s\xE2\x81\xBB\xC2\xB9)", "(cm/s^2)", kDeg, 0.01, true, false},
       {"{mdps}", "{ug}", 1e-3 * kDeg, 1e-6 * kG, false, false},
       {" deg/s", " mg", kDeg, 1e-3 * kG, true, false},
       {"_rpm", "_g", 2 * std::numbers::pi / 60, kG, false, true},
       {"(degrees per second)", "(ft/s^2)", kDeg, 0.3048, true, false}}};
  for (const Case& each : cases) {
    SCOPED_TRACE(each.rate);
    std::string header = "time";
    for (const char axis : {'x', 'y', 'z'}) header += fmt::format(",gyro_{}{}", axis, each.rate);
    for (const char axis : {'x', 'y', 'z'}) header += fmt::format(",acc_{}{}", axis, each.force);
    const FileContent content =
        Inspect(header + "\n" +
                Inertial(TimeRatesForces(1.0, 1.0 / each.rate_size, 1.0 / each.force_size)));
    EXPECT_EQ(content.kind, FileKind::kImu) << content.why;
    EXPECT_EQ(content.rates_in_deg, each.deg);
    EXPECT_EQ(content.forces_in_g, each.g);
    EXPECT_NEAR(content.rate_unit, each.deg || each.rate_size == 1.0 ? 0.0 : each.rate_size, 1e-12);
    EXPECT_NEAR(content.force_unit, each.g || each.force_size == 1.0 ? 0.0 : each.force_size,
                1e-12);
  }
  const FileContent unknown = Inspect("t,wx (rev/day),wy (rev/day),wz (rev/day),ax,ay,az\n" +
                                      Inertial(TimeRatesForces(1.0)));
  EXPECT_EQ(unknown.kind, FileKind::kUnknown);
  EXPECT_THAT(unknown.why, HasSubstr("the unit of the angular rates, 'rev/day', is not known"));
}

TEST(ContentInertial, UnitsOfTheTime) {
  struct Case {
    const char *name, *column;
    double factor;
  };
  const std::array<Case, 6> cases{{{"time (min)", "t_min", 1.0 / 60},
                                   {"Time [minutes]", "t_min", 1.0 / 60},
                                   {"SampleTimeFine", "t_100us", 1e4},
                                   {"SampleTimeFine", "t_us", 1e6},
                                   {"timestamp", "t_us", 1e6},
                                   {"TimeUS", "t_us", 1e6}}};
  for (const Case& each : cases) {
    SCOPED_TRACE(each.name);
    const FileContent content = Inspect(std::string(each.name) + ",wx,wy,wz,ax,ay,az\n" +
                                        Inertial(TimeRatesForces(each.factor)));
    EXPECT_EQ(content.kind, FileKind::kImu) << content.why;
    EXPECT_THAT(content.columns, ElementsAre(each.column, "wx", "wy", "wz", "fx", "fy", "fz"));
  }
  const FileContent hours =
      Inspect("time (h),wx,wy,wz,ax,ay,az\n" + Inertial(TimeRatesForces(1.0 / 3600)));
  EXPECT_EQ(hours.kind, FileKind::kUnknown);
  EXPECT_THAT(hours.why, HasSubstr("the unit of 'time (h)' is not known"));
}

TEST(ContentInertial, VectorsDoNotCross) {
  const auto field = [](double t) {
    return Row{0.2 * std::cos(0.1 * t), -0.2 * std::sin(0.1 * t), 0.42};
  };
  const FileContent plain = Inspect(Inertial([&](double t, const Row& w, const Row& f) {
    return Plus(Plus(Plus(Plus({381000 + t}, field(t)), f), w), {25.1 + 0.01 * t, 101.3});
  }));
  EXPECT_THAT(plain.columns,
              ElementsAre("t", "skip", "skip", "skip", "fx", "fy", "fz", "wx", "wy", "wz"));
  const FileContent apart = Inspect(Inertial([&](double t, const Row& w, const Row& f) {
    return Plus(Plus(Plus(Plus({381000 + t}, Times(field(t), 50)), f), {35.1 + 0.01 * t}), w);
  }));
  EXPECT_THAT(apart.columns,
              ElementsAre("t", "skip", "skip", "skip", "fx", "fy", "fz", "skip", "wx", "wy", "wz"));
  // At rest, biases exceed the noise of the rates.
  const FileContent rest = Inspect(Inertial([&](double t, const Row& w, const Row& f) {
    const Row still{0.02 + 1e-3 * w[0], -0.01 + 1e-3 * w[1], 0.03 + 1e-3 * f[0]};
    return Plus(Plus(Plus({381000 + t}, still), {0.1 + 0.1 * f[0], 0.1 * f[1], -9.8 + 0.1 * w[0]}),
                {0.2 + 1e-3 * f[1], 0.1 + 1e-3 * w[1], 0.4 + 1e-3 * w[2]});
  }));
  EXPECT_THAT(rest.columns, ElementsAre("t", "wx", "wy", "wz", "fx", "fy", "fz"));
  // The name of the message and a checksum, after the time of a terminal.
  std::string log;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.02 * i, shake = std::sin(11.3 * i);
    const Row m = field(t);
    log += fmt::format(
        "{:.3f},$VNIMU,{:+.4f},{:+.4f},{:+.4f},{:+.4f},{:+.4f},{:+.4f},{:+.5f},"
        "{:+.5f},{:+.5f}*5F\n",
        381000 + t, m[0], m[1], m[2], 0.3 * shake, 0.8 * std::sin(t), -9.8, 0.1 * std::sin(t),
        0.02 * shake, 0.05 * std::cos(0.3 * t));
  }
  EXPECT_THAT(Inspect(log).columns,
              ElementsAre("t", "skip", "skip", "skip", "skip", "fx", "fy", "fz", "wx", "wy", "wz"));
}

TEST(ContentInertial, AnglesAreNotRates) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  for (const double unit : {1.0, kDegrees}) {
    for (const bool rates_first : {false, true}) {
      SCOPED_TRACE(fmt::format("{} {}", unit, rates_first));
      Row angles{0.05, -0.03, 0.2};
      const std::string rows = Inertial([&](double t, const Row& slow, const Row& f) {
        const Row w{slow[0], slow[1], slow[2] + 0.25 * std::sin(0.1 * t)};
        for (std::size_t k = 0; k < 3; ++k) angles[k] += 0.02 * w[k];
        const Row first = Plus({381000 + t}, Times(angles, unit));
        return rates_first ? Plus(Plus(first, w), f) : Plus(Plus(first, f), w);
      });
      for (const char* header : {"", "Zeit,Winkel1,Winkel2,Winkel3,B1,B2,B3,D1,D2,D3\n"}) {
        const FileContent content = Inspect(header + rows);
        const std::string w = rates_first ? "wx, wy, wz, fx, fy, fz" : "fx, fy, fz, wx, wy, wz";
        EXPECT_EQ(FormatColumnNames(content.columns), "[t, skip, skip, skip, " + w + "]");
        EXPECT_FALSE(content.rates_in_deg);
      }
    }
  }
}

TEST(ContentInertial, GravityAloneIsNotTheForce) {
  const FileContent content = Inspect(Inertial([](double t, const Row& w, const Row& f) {
    const double roll = 0.1 * std::sin(0.7 * t);
    return Plus(Plus(Plus({381000 + t}, w), {f[0], f[1], f[2] + 9.81}),
                {0.0, 9.8 * std::sin(roll), -9.8 * std::cos(roll)});
  }));
  EXPECT_EQ(content.kind, FileKind::kUnknown);
  EXPECT_THAT(content.why, HasSubstr("gravity without accelerations"));
}

TEST(ContentInertial, QuaternionsAreNeitherRatesNorForces) {
  const auto quaternion = [](double t) {
    return Row{std::cos(0.01 * t), 0.6 * std::sin(0.01 * t), 0.0, 0.8 * std::sin(0.01 * t)};
  };
  const FileContent plain = Inspect(Inertial([&](double t, const Row& w, const Row& f) {
    return Plus(Plus(Plus({381000 + t}, quaternion(t)), w), f);
  }));
  EXPECT_THAT(plain.columns,
              ElementsAre("t", "skip", "skip", "skip", "skip", "wx", "wy", "wz", "fx", "fy", "fz"));
  const std::string increments = Inertial([](double t, const Row& w, const Row& f) {
    const Row half = Times(w, 0.01);
    return Plus({std::round(1e4 * t), 1 - 0.5 * (half[0] * half[0] + half[1] * half[1])},
                Plus(half, Times(f, 0.02)));
  });
  const FileContent named = Inspect(
      "SampleTimeFine,OriInc_q0,OriInc_q1,OriInc_q2,OriInc_q3,VelInc_X,VelInc_Y,VelInc_Z\n" +
      increments);
  EXPECT_EQ(named.kind, FileKind::kUnknown);
  EXPECT_THAT(named.why, HasSubstr("OriInc"));
}

TEST(ContentInertial, PositionsInTheSameFile) {
  for (const int every : {1, 12}) {
    SCOPED_TRACE(every);
    int i = 0;
    std::string text =
        "PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tLatitude\t"
        "Longitude\tAltitude\n";
    text += Inertial(
        [&](double t, const Row& w, const Row& f) {
          const Row inertial = Plus(Plus({0.0 + i, std::round(1e4 * (381000 + t))}, f), w);
          return Plus(inertial, {46.5 + 1e-5 * t, 6.5, i++ % every == 0 ? 500.0 : -1.0});
        },
        "\t");
    // Rows without a position end with empty fields.
    for (std::size_t at = 0; (at = text.find("\t-1\n")) != text.npos;) {
      std::size_t begin = at;
      for (int k = 0; k < 2; ++k) begin = text.rfind('\t', begin - 1);
      text.replace(begin, at + 3 - begin, "\t\t\t");
    }
    const testing::TempFolder folder;
    folder.Write("data.csv", text);
    const std::vector<FileContent> contents = InspectFolder(folder.path());
    const FileContent& content = contents.front();
    EXPECT_EQ(content.kind, FileKind::kImu) << content.why;
    EXPECT_THAT(content.columns,
                ElementsAre("skip", "t_100us", "fx", "fy", "fz", "wx", "wy", "wz"));
    if (every == 1) {  // the output of a filter
      EXPECT_EQ(contents.size(), 1u);
      EXPECT_THAT(content.why, HasSubstr("not positions of a receiver"));
      continue;
    }
    ASSERT_EQ(contents.size(), 2u);
    EXPECT_EQ(contents[1].kind, FileKind::kGnss);
    EXPECT_TRUE(contents[1].only_changed);
    EXPECT_THAT(contents[1].columns, ElementsAre("skip", "t_100us", "skip", "skip", "skip", "skip",
                                                 "skip", "skip", "lat", "lon", "h"));
  }
}

}  // namespace dn::files_test
