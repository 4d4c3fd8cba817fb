// How good is a calibration? Its uncertainty in pixels, the next view, the truth, OpenCV.
#include <iostream>
#include <tagcal/estimate/advice.hpp>
#include <tagcal/estimate/calibrate.hpp>
#include <tagcal/io/dataset_file.hpp>
#include <tagcal/uncertainty/lens_difference.hpp>
#include <tagcal/uncertainty/projection_uncertainty.hpp>
#include <tagcal/validate/validate.hpp>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const tagcal::Dataset dataset = tagcal::read_dataset(argv[1]).dataset;
  const tagcal::Calibration found = tagcal::calibrate(dataset);
  if (!tagcal::is_answer(found.status) || !found.camera || !dataset.truth) return 3;

  // uncertainty/seen_region.hpp: where corners were, and which parts of the image have none
  const std::vector<Eigen::Vector2d> samples = found.seen.samples();
  std::cout << "seen " << 100 * found.seen.share() << " %\n";
  // uncertainty/projection_uncertainty.hpp: standard deviation of the projection, here at 1 m
  const tagcal::UncertainCamera& lens = *found.claim;
  const tagcal::ImageGrid grid{dataset.image_size};
  std::cout << "sd at 1 m " << tagcal::projection_uncertainty(lens, grid, samples, 1).region_px
            << " px\n";
  // uncertainty/lens_difference.hpp: how far two cameras project apart, a turned camera taken out
  if (const auto difference = tagcal::lens_difference(dataset.truth->camera, *found.camera, samples,
                                                      tagcal::kInfinitelyFar))
    std::cout << "off the truth by " << difference->rms_px << " px\n";
  // estimate/advice.hpp: the view to take next
  if (const auto advice = tagcal::advise(dataset, found)) std::cout << advice->sentence << "\n";
  // validate/validate.hpp: against cv::projectPoints and the truth
  const tagcal::Validation check = tagcal::validate(*found.camera, found.sigmas, dataset);
  std::cout << (check.opencv_agrees ? "OpenCV agrees\n" : "OpenCV disagrees\n");
}
