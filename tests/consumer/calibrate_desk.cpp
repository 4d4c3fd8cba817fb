// Calibrates a data set, with matrices of its own beside those of the library.
#include <Eigen/Dense>
#include <iostream>
#include <tagcal/estimate/calibrate.hpp>
#include <tagcal/io/dataset_file.hpp>
#include <tagcal/uncertainty/lens_difference.hpp>
#include <vector>

namespace {

// By code that the library has compiled into it, too, with its own flags.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& matrix) {
  const auto identity = Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(matrix);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(matrix);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(matrix);
  if (spectrum.eigenvalues()[0] <= 0 || svd.singularValues()[0] <= 0 || !ldlt.isPositive())
    return Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols());
  return qr.solve(identity);
}

}  // namespace

int main(int, char** argv) {
  const tagcal::Dataset dataset = tagcal::read_dataset(argv[1]).dataset;
  std::vector<tagcal::Calibration> results;
  for (const char* model : {"radial1", "opencv5"}) {
    tagcal::CalibrateOptions options;
    options.model = model;
    results.push_back(tagcal::calibrate(dataset, options));
    if (!tagcal::is_answer(results.back().status)) return 1;
  }
  tagcal::Calibration copy = results.front();
  copy.covariance = inverse_of(results.back().covariance);
  results.erase(results.begin());
  const Eigen::MatrixXd unit = copy.covariance * results.front().covariance;
  if (!unit.isIdentity(1e-3)) return 2;
  copy = results.front();
  std::cout << "fx " << tagcal::parameters(copy.camera->lens)[0] << "\n";
}
