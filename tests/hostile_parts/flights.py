"""The small flight that is attacked. It is simulated once and calibrated in a fraction of 1 s."""

import math
import pathlib
import shutil
import struct

from . import shards, strips
from .program import Conditions
from .rotation import product, quaternion

SCENARIO = """name: small
origin_deg_m: [46.57, 6.52, 400]
start_s: 381000
plan:
  warm_up_s: 60
  lines:
    - [-150, 0, 150, 0, 200, 30]
    - [0, -150, 0, 150, 240, 30]
  bank_deg: 35
  crab_deg: 3
  stabilised_mount: false
  turbulence:
    roll_deg: 1.0
    pitch_deg: 0.7
    heading_deg: 0.7
    speed_m_s: 1.0
    height_m: 2.0
terrain:
  kind: built_up
  relief_m: 30
  wavelength_m: 500
  buildings_per_km2: 800
  trees_per_km2: 0
  seed: 3
imu:
  rate_hz: 25
  preset: airins
gnss:
  rate_hz: 1
  sigma_enu_m: [0.015, 0.015, 0.03]
  lever_arm_m: [0.4, -0.1, -1.1]
  velocity: false
lidar:
  R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
  scan_axis: [0, 1, 0]
  nadir_axis: [1, 0, 0]
  lever_arm_m: [0.14, -0.02, 0.21]
  boresight_deg: [0.2, 0.03, 0.35]
  fov_deg: 75
  pulse_rate_hz: 200000
  gsd_m: 0.2
  beam_divergence_mrad: 0.35
pairs:
  count: 60
control:
  points: 6
  checks: 3
  corners: 2
  corner_checks: 1
  sigma_m: [0.01, 0.01, 0.015]
"""

FLIGHT_YAML = """name: small
body: FRD
frame:
  origin_deg_m: [46.57, 6.52, 400]
time_span_s: [381000, 381300]
strips:
  - {name: "1", t0: 381060, t1: 381071}
  - {name: "2", t0: 381121, t1: 381133}
strips_crs: map
imu:
  file: IMU.txt
  format: odyn
  sampling: mean
  rate_unit: rad/s
  force_unit: m/s^2
  R_imu_to_body: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
  time_offset_s: 0
  max_gap_s: 0.3
  grade: ~
  gyro:
    white_deg_sqrt_h: 0.0014
    processes:
      - {type: random_constant, sigma_deg_h: 0.01}
      - {type: gauss_markov, sigma_deg_h: 0.003, tau_s: 3600}
  accel:
    white_m_s_sqrt_h: 0.0058839899999999995
    processes:
      - {type: random_constant, sigma_mg: 0.03}
      - {type: gauss_markov, sigma_mg: 0.01, tau_s: 3600}
gnss:
  file: GPS.txt
  format: odyn
  crs: geographic
  north: geodetic
  time_offset_s: 0
  lever_arm_m: [0.4, -0.1, -1.1]
  sigma_enu_m: [0.015, 0.015, 0.03]
  sigma_scale: 1
  use_velocity: auto
  processes: []
  robust: none
lidar:
  p2p: [lidar/1_2.txt]
  surface_pairs: [surfaces/1_2.txt]
  time_offset_s: 0
  pairs:
    strategy: all
    count: 50
    freq_hz: 10
    window_s: 0.5
    seed: 0
  R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
  lever_arm_m: [0.14, -0.02, 0.21]
  boresight_deg: [0, 0, 0]
  boresight_sigma_deg: ~
  scan_axis: [0, 1, 0]
  nadir_axis: [1, 0, 0]
  gsd_m: 0.2
  sigma_p_m: 0.05773502691896258
  robust: none
control:
  files: ["control/*.txt"]
  crs: geographic
  sigma_enu_m: [0.01, 0.01, 0.015]
  laser_sigma_m: 0.04
  datum_shift_sigma_m: [0.05, 0.05, 0.1]
  checks: [C1, C2, C3]
  search_radius_m: 1.0
  corner_radius_m: 3.0
trajectory:
  file: trajectory.out
  crs: geographic
  attitude: quaternion_ned
  north: geodetic
  sigma_xy_m: 0.03
  sigma_z_m: 0.05
  sigma_rp_deg: 0.003
  sigma_y_deg: 0.005
gh:
  rotation: exp
  libor_compat: false
estimate: [boresight]
network:
  inertial: preintegrated
  node_rate_hz: auto
"""

SECOND_SCANNER = [
    ("R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]",
     "R_sensor_to_body: [[0.5, 0.8660254037844386, 0], [0, 0, 1], [0.8660254037844386, -0.5, 0]]"),
    ("lever_arm_m: [0.14, -0.02, 0.21]", "lever_arm_m: [0.3, 0, 0.1]"),
    ("boresight_deg: [0.2, 0.03, 0.35]", "boresight_deg: [-0.4, 0.5, 0.1]"),
    ("p2p: [lidar/1_2.txt]", "p2p: [lidar_b/1_2.txt]"),
    ("fov_deg: 75", """fov_deg: 75
  beams:
    angles_deg: [-10, 0, 10]
    rotation_hz: 10
    angle_error_deg: [0.05, 0, -0.05]
    range_error_m: [0.01, -0.01, 0]"""),
    ("robust: none", """robust: none
  beams:
    count: 3
    angles_deg: [-10, 0, 10]
    angle_sigma_deg: 0.1
    range_offset_sigma_m: 0.03"""),
]
SURFACE_PAIRS = "  surface_pairs: [surfaces/1_2.txt]\n"  # for one scanner only
PAIRS_BETWEEN = """pairs_between:
  - scanners: [a, b]
    p2p: ["lidar_a_b/*.txt"]
    sigma_p_m: 0.058
"""


def with_two_scanners(text):
    """Returns a flight.yaml or scenario with a list of two scanners in place of one.

    The second scanner has three beams.
    """
    begin = text.index("lidar:\n") + len("lidar:\n")
    end = next(i for i in range(begin, len(text)) if text[i - 1] == "\n" and text[i] != " ")
    first = text[begin:end].replace(SURFACE_PAIRS, "")
    second = first
    for before, after in SECOND_SCANNER:
        second = second.replace(before, after)
    first = first.replace("lidar/1_2.txt", "lidar_a/1_2.txt")
    return text[:begin] + as_item("a", first) + as_item("b", second) + text[end:]


def as_item(name, section):
    lines = [f"  - name: {name}"] + ["  " + line for line in section.splitlines()]
    return "\n".join(lines) + "\n"


class NoBase(Exception):
    pass


class Base:
    """The undamaged flight and scenario, from which every attack starts."""

    def __init__(self, program, folder, seed):
        self.program = program
        self.flight = pathlib.Path(folder) / "flight"
        self.results = pathlib.Path(folder) / "results"  # of commands on the flight
        self.seed = seed
        self.yaml = FLIGHT_YAML
        self.scenario = SCENARIO
        self.yaml_two = ""  # with two scanners
        self.scenario_two = with_two_scanners(SCENARIO)

    def make(self):
        work = self.flight.parent
        (work / "here").mkdir()
        (work / "tmp").mkdir()
        (work / "small.yaml").write_text(SCENARIO)
        self._run("simulate", work / "small.yaml", "--seed", "1", "--out", self.flight)
        self._add_surface_pairs()
        written = (self.flight / "flight.yaml").read_text()
        self.yaml = known_keys(written, self.program, work)
        self._run("smooth", self.flight, "--out", work / "smooth")
        for name in ("trajectory.out", "trajectory_sigma.txt", "trajectory_covariance.txt"):
            if (work / "smooth" / name).exists():
                shutil.copy(work / "smooth" / name, self.flight / name)
        for name in ("report.json", "config.resolved.yaml"):
            (self.flight / name).unlink(missing_ok=True)
        self._add_second_scanner(work)
        (self.flight / "flight.yaml").write_text(self.yaml)
        (self.flight / "strips").mkdir()
        (self.flight / "strips" / "1.las").write_bytes(strips.las(strips.epochs(381060, 381071, 300)))
        (self.flight / "strips" / "2.txt").write_text(strips.text(strips.epochs(381121, 381133, 300)))
        thin_sbet(self.flight / "reference.out", 4)
        self.results.mkdir()

    def _add_surface_pairs(self):
        """Makes surface pairs from the first pairs, along the vertical."""
        pairs = (self.flight / "lidar" / "1_2.txt").read_text().splitlines()
        rows = [line.split(",")[:8] for line in pairs if not line.startswith("#")][:20]
        (self.flight / "surfaces").mkdir()
        (self.flight / "surfaces" / "1_2.txt").write_text(
            "".join(",".join(row) + ", 0, 0, 1, 0.06\n" for row in rows))

    def _add_second_scanner(self, work):
        """Adds the pairs of two scanners, and checks the flight with both."""
        (work / "two.yaml").write_text(self.scenario_two)
        self._run("simulate", work / "two.yaml", "--seed", "1", "--out", work / "two")
        for name in ("lidar_a", "lidar_b", "lidar_a_b"):
            shutil.copytree(work / "two" / name, self.flight / name)
        self.yaml_two = with_two_scanners(self.yaml) + PAIRS_BETWEEN
        (self.flight / "flight.yaml").write_text(self.yaml_two)
        self._run("calibrate", self.flight, "--out", work / "two_result")

    def make_results(self):
        """The results folders that are attacked."""
        self._run("smooth", self.flight, "--out", self.results / "smoothed")
        self._run("calibrate", self.flight, "--out", self.results / "calibrated")
        shards.make(self, self._run)

    def _run(self, *arguments):
        outcome = self.program.run([str(a) for a in arguments], self.flight.parent)
        if outcome.exit_code != 0:
            raise NoBase(f"dn {arguments[0]}: exit {outcome.exit_code}: {outcome.err}")


def known_keys(written, program, work):
    """Returns FLIGHT_YAML without the keys that this version of the program does not have."""
    text = FLIGHT_YAML
    trial = work / "trial"
    shutil.copytree(work / "flight", trial)
    while True:
        (trial / "flight.yaml").write_text(text)
        outcome = program.run(["check", str(trial)], work, Conditions(time_limit_s=20))
        if outcome.exit_code != 2 or "unknown key" not in outcome.err:
            break
        line = int(outcome.err.split("flight.yaml:")[1].split(":")[0].split(")")[0].split(",")[0])
        lines = text.splitlines()
        del lines[line - 1]
        text = "\n".join(lines) + "\n"
    shutil.rmtree(trial)
    if outcome.exit_code != 0:
        raise NoBase(f"dn check on the undamaged flight: {outcome.err}\n{written}")
    return text


def thin_sbet(path, step):
    content = path.read_bytes()
    records = [content[i:i + 136] for i in range(0, len(content), 136)]
    path.write_bytes(b"".join(records[::step] + records[-1:]))


def text_trajectory(sbet):
    """Returns the trajectory of the flight in the ODyN text format."""
    rows = []
    for i in range(0, len(sbet) - 135, 136):
        t, lat, lon, h, *_, roll, pitch, heading, wander = struct.unpack("<11d", sbet[i:i + 88])
        w, x, y, z = attitude(roll, pitch, heading - wander)
        rows.append(f"{t!r}, {math.degrees(lat)!r}, {math.degrees(lon)!r}, {h!r}, "
                    f"{w!r}, {x!r}, {y!r}, {z!r}\n")
    return "".join(rows)


def attitude(roll, pitch, heading):
    """Returns the quaternion from body to north-east-down."""
    turns = [(0, 0, heading), (0, pitch, 0), (roll, 0, 0)]
    down, right, forward = (quaternion([math.degrees(x) for x in turn]) for turn in turns)
    return product(product(down, right), forward)
