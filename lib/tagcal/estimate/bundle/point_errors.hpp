#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/estimate/bundle/covariance.hpp"

namespace tagcal::internal {

// The covariance that errors of the target's points add to that of a bundle's parameters. The
// errors are the same in all views, so that more views do not average them: errors of the print,
// and of corners that are found beside the ink's.
//
// With the displacements d of the points, each along three axes, D the residuals' Jacobian by them,
// and Q the projection that takes out poses, row terms, lens and board, the residuals r of all
// views have
//   E |D'r|^2 = sigma^2 tr(D'QD) + tau^2 tr((D'QD)^2)
// for noise of variance sigma^2, that of the residuals, and displacements of variance tau^2. These
// are seen if they exceed policy::kSignificant standard deviations of what noise does (a variance
// component by moments: Searle, Casella & McCulloch, Variance Components, 1992, chapter 5).
// With the Jacobian B by the parameters of lens and board, and G_v = B'QD of a view, where Q takes
// out its pose and row terms alone, they add the positive part of
//   tau^2 H^-1 (sum_v G_v sum_w G_w' - sum_v G_v G_v') H^-1 / sigma^4:
// the products of different views, as the spread of the views has those of each alone (clusters in
// two ways: Cameron, Gelbach & Miller, J. Bus. Econ. Stat. 29, 238 (2011)).
// `sigma`: of the bundle's noise. No value if no displacements are seen, or if a view does not
// determine its pose.
std::optional<Eigen::MatrixXd> covariance_of_point_errors(const Bundle& bundle,
                                                          const BundleInformation& information,
                                                          double sigma);

}  // namespace tagcal::internal
