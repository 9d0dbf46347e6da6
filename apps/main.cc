#include <cstdio>

#include "command.h"

int main(int argc, char** argv) {
  CLI::App program{
      "dn fuses raw inertial, GNSS and lidar data of a flight in one adjustment: it estimates "
      "trajectory,\n"
      "time-correlated inertial errors and lidar boresight together, with their covariance.",
      "dn"};
  program.set_version_flag("--version", "dn " DN_VERSION);
  program.require_subcommand(1);
  program.footer("Example: dn simulate lar3 --out flight && dn calibrate flight --out result");
  dn::apps::Action action;
  dn::apps::AddCheck(&program, &action);
  dn::apps::AddCalibrate(&program, &action);
  dn::apps::AddSmooth(&program, &action);
  dn::apps::AddSimulate(&program, &action);
  dn::apps::AddMonteCarlo(&program, &action);
  dn::apps::AddAllan(&program, &action);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = program.exit(error);
    return code == 0 ? 0 : 2;
  }
  dn::apps::RememberCommandLine(argc, argv);
  dn::apps::InstallInterruptHandler();
  return action();
}
