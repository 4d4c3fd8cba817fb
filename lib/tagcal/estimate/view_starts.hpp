#pragma once

#include "tagcal/estimate/view_fit.hpp"

namespace tagcal {

template <int N>
using ViewStarts = Solutions<ViewStart<N>, 16>;  // four triples of points, four poses each

// Where solve_view may begin: the closed forms that suit the shape of the points, those of lower
// cost first. Of many points some are enough for that. Empty where none puts every point in the
// lens' domain.
ViewStarts<6> find_starts(const PoseProblem& problem, const Lens& lens);

// The same with a focal length; `guess` is a pinhole, for where no closed form tells.
ViewStarts<7> find_starts_with_focal(const PoseProblem& problem, const Lens& guess, ViewSums& sums);

}  // namespace tagcal
