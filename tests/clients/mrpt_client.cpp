// Reads scans through MRPT's drivers: `mrpt_client urg|lms|rplidar PORT SCANS [BAUD]`.
// Prints a line a scan: number of beams, of valid ones, field of view [rad] (negative: from
// left to right), and the ranges; 0 is none.
// RPLIDARs are driven by the vendor's own SDK, which MRPT brings.
#include <mrpt/hwdrivers/CHokuyoURG.h>
#include <mrpt/hwdrivers/CRoboPeakLidar.h>
#include <mrpt/hwdrivers/CSickLaserSerial.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

using namespace mrpt::hwdrivers;

static std::unique_ptr<C2DRangeFinderAbstract> make(
    const std::string& device, const std::string& port, int baud) {
  if (device == "urg") {
    auto sensor = std::make_unique<CHokuyoURG>();
    sensor->setSerialPort(port);
    return sensor;
  }
  if (device == "lms") {
    auto sensor = std::make_unique<CSickLaserSerial>();
    sensor->setSerialPort(port);
    sensor->setBaudRate(baud);
    sensor->setScanFOV(180);
    sensor->setScanResolution(50);
    sensor->setMillimeterMode(true);
    return sensor;
  }
  auto sensor = std::make_unique<CRoboPeakLidar>();
  sensor->setSerialPort(port);
  return sensor;
}

int main(int count, char** arguments) {
  if (count < 4) return 64;
  const int wanted = std::atoi(arguments[3]);
  auto sensor = make(arguments[1], arguments[2], count > 4 ? std::atoi(arguments[4]) : 38400);
  try {
    sensor->initialize();
    if (!sensor->turnOn()) throw std::runtime_error("turnOn failed");
    for (int scans = 0, tries = 0; scans < wanted && tries < 2000; tries++) {
      bool there = false, failed = false;
      mrpt::obs::CObservation2DRangeScan scan;
      sensor->doProcessSimple(there, scan, failed);
      if (failed) throw std::runtime_error("hardware error");
      if (!there) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        continue;
      }
      scans++;
      const auto beams = scan.getScanSize();
      int valid = 0;
      for (size_t i = 0; i < beams; i++) valid += scan.getScanRangeValidity(i) ? 1 : 0;
      std::printf("scan %zu %d %.5f", beams, valid, (scan.rightToLeft ? 1 : -1) * double(scan.aperture));
      for (size_t i = 0; i < beams; i++)
        std::printf(" %.3f", scan.getScanRangeValidity(i) ? double(scan.getScanRange(i)) : 0.0);
      std::printf("\n");
    }
    sensor->turnOff();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "failed: %s\n", error.what());
    return 1;
  }
  return 0;
}
