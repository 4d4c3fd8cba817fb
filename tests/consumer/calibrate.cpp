// Calibrates the data set in a folder and writes camera.yaml.
#include <fstream>
#include <iostream>
#include <tagcal/error.hpp>
#include <tagcal/estimate/calibrate.hpp>
#include <tagcal/io/calibration_file.hpp>
#include <tagcal/io/dataset_file.hpp>

int main(int argc, char** argv) try {
  if (argc != 2) throw tagcal::Error("usage: calibrate DATASET");
  const tagcal::Dataset dataset = tagcal::read_dataset(argv[1]).dataset;

  const tagcal::Calibration calibration = tagcal::calibrate(dataset);
  for (const tagcal::Finding& finding : calibration.findings)
    std::cerr << finding.code << ": " << finding.sentence << "\n";
  std::cout << tagcal::status_name(calibration.status) << ", " << calibration.model << "\n";
  if (!tagcal::is_answer(calibration.status) || !calibration.camera) return 3;

  const auto names = tagcal::parameter_names(calibration.camera->lens);
  const auto values = tagcal::parameters(calibration.camera->lens);
  for (std::size_t i = 0; i < values.size(); ++i)
    std::cout << names[i] << " " << values[i] << " +- " << calibration.sigmas[i] << "\n";
  std::ofstream("camera.yaml") << tagcal::calibration_yaml(calibration);
} catch (const tagcal::Error& error) {
  std::cerr << error.what() << "\n";
  return 2;
}
