#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/random.hpp"

namespace tagcal::internal {

// A problem that `ransac` solves: correspondences, of which some are wrong, and models of them.
template <typename P>
concept RansacFitter = requires(P fitter, const typename P::Model& model,
                                std::span<const std::size_t> chosen,
                                std::vector<typename P::Model>& models) {
  // Correspondences that samples are drawn from, ascending, and the size of a minimal sample.
  { fitter.usable() } -> std::convertible_to<std::span<const std::size_t>>;
  { fitter.sample_size() } -> std::convertible_to<std::size_t>;
  // Adds the models that fit a minimal sample, one or more groups, or all correspondences.
  fitter.solve(chosen, models);
  // The least-squares model of the chosen correspondences, from a model that is near.
  { fitter.refit(model, chosen) } -> std::convertible_to<std::optional<typename P::Model>>;
  // Squared residuals of all correspondences.
  { fitter.squares(model) } -> std::convertible_to<std::span<const double>>;
};

// Scores the squared residuals of a model: the lowest score is the best.
template <typename S>
concept RansacScore = requires(const S score, std::span<const double> squares, double value) {
  { score(squares) } -> std::convertible_to<double>;
  // Largest squared residual of an inlier of a model with this score.
  { score.inlier_square(value) } -> std::convertible_to<double>;
  // False if the score is too high for its inliers to end the search.
  { score.may_end_search(value) } -> std::convertible_to<bool>;
};

struct RansacOptions {
  std::uint64_t seed = 0;
  std::span<const int> groups = {};  // of each correspondence, sampled as a whole; or empty
  std::size_t groups_per_sample = 1;
  double least_share = 0;        // of inliers below which the search may miss a consensus
  bool starts_from_all = false;  // the first sample is that of all correspondences
};

template <typename Model>
struct Consensus {
  Model model;                       // refined on the inliers
  std::vector<std::size_t> inliers;  // ascending
  int num_samples = 0;               // taken
};

// Draws whole groups of four correspondences or more and minimal samples, in turn.
class RansacSampler {
 public:
  RansacSampler(std::span<const std::size_t> usable, std::size_t sample_size,
                const RansacOptions& options)
      : usable_(usable), size_(sample_size), options_(options), random_(options.seed) {
    std::map<int, std::vector<std::size_t>> groups;
    if (!options.groups.empty())
      for (const std::size_t i : usable) groups[options.groups[i]].push_back(i);
    for (const auto& [id, members] : groups)
      if (members.size() >= 4) groups_.push_back(members);
  }

  std::span<const std::size_t> next() {
    const std::size_t count = count_++;
    if (count == 0 && options_.starts_from_all) return usable_;
    if (count % 2 == 0 && !groups_.empty())
      draw_groups(count / 2);
    else
      draw_minimal();
    return sample_;
  }

  // Number of samples that miss a consensus with this share of inliers with probability
  // kWrongConsensus.
  int count_for(double share) const {
    constexpr int kMost = 50000;  // samples, as a limit of work
    if (share <= 0) return kMost;
    const double good = std::pow(share, static_cast<double>(size_));
    if (good >= 1) return 1;
    const double minimal = std::log(policy::kWrongConsensus) / std::log1p(-good);
    return static_cast<int>(
        std::min<double>(kMost, std::ceil(groups_.empty() ? minimal : 2 * minimal)));
  }

 private:
  void draw_groups(std::size_t first) {
    sample_ = groups_[first % groups_.size()];
    for (std::size_t k = 1; k < std::min(options_.groups_per_sample, groups_.size()); ++k)
      if (const auto& other = groups_[random_.index(groups_.size())];
          other.front() != sample_.front())
        sample_.insert(sample_.end(), other.begin(), other.end());
  }

  void draw_minimal() {
    sample_.clear();
    while (sample_.size() < size_) {
      const std::size_t i = usable_[random_.index(usable_.size())];
      if (std::find(sample_.begin(), sample_.end(), i) == sample_.end()) sample_.push_back(i);
    }
  }

  std::span<const std::size_t> usable_;
  std::size_t size_, count_ = 0;
  RansacOptions options_;
  Random random_;
  std::vector<std::vector<std::size_t>> groups_;
  std::vector<std::size_t> sample_;
};

// Returns the indices of the squares up to a bound, ascending.
inline std::vector<std::size_t> indices_within(std::span<const double> squares, double bound) {
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < squares.size(); ++i)
    if (squares[i] <= bound) result.push_back(i);
  return result;
}

template <typename Model>
struct ScoredModel {
  Model model;
  std::span<const double> squares;  // valid until the fitter's next ones
  double score;
};

// Refits the model of a sample to its inliers, whose tolerance shrinks. Calls keep for the model
// and for each that follows.
template <RansacFitter Fitter, RansacScore Score, typename Keep>
void optimise_locally(Fitter& fitter, const Score& score, std::span<const std::size_t> sample,
                      ScoredModel<typename Fitter::Model> local, const Keep& keep) {
  keep(local);
  std::vector<std::size_t> fitted(sample.begin(), sample.end());
  for (const double tolerances : {3.0, 2.0, 1.5, 1.0}) {  // numeric: tried values
    const double bound = tolerances * tolerances * score.inlier_square(local.score);
    std::vector<std::size_t> inliers = indices_within(local.squares, bound);
    if (inliers == fitted) continue;
    const auto refitted = fitter.refit(local.model, inliers);
    if (!refitted) return;
    fitted = std::move(inliers);
    local.model = *refitted;
    local.squares = fitter.squares(local.model);
    local.score = score(local.squares);
    keep(local);
  }
}

// Locally optimised random sample consensus (Chum, Matas & Kittler, DAGM 2003): a sample's model
// that scores better than those of all samples before is refitted to its inliers. The search ends
// when the probability that a better consensus was missed, by the share of inliers, is below
// policy::kWrongConsensus. Equal seeds give equal results. No value if no sample has a model.
template <RansacFitter Fitter, RansacScore Score>
std::optional<Consensus<typename Fitter::Model>> ransac(Fitter& fitter, const Score& score,
                                                        const RansacOptions& options) {
  using Model = typename Fitter::Model;
  const std::span<const std::size_t> usable = fitter.usable();
  if (usable.size() < fitter.sample_size()) return std::nullopt;
  std::optional<Consensus<Model>> best;
  double best_score = std::numeric_limits<double>::infinity(), best_of_samples = best_score;
  const auto keep = [&](const ScoredModel<Model>& scored) {
    if (!(scored.score < best_score)) return;
    best_score = scored.score;
    best = {scored.model, indices_within(scored.squares, score.inlier_square(best_score))};
  };
  RansacSampler sampler(usable, fitter.sample_size(), options);
  std::vector<Model> models;
  int count = 0;
  for (int wanted = sampler.count_for(options.least_share); count < wanted; ++count) {
    const std::span<const std::size_t> sample = sampler.next();
    models.clear();
    fitter.solve(sample, models);
    const double before = best_score;
    for (const Model& model : models) {
      const std::span<const double> squares = fitter.squares(model);
      const double of_model = score(squares);
      if (!(of_model < best_of_samples)) continue;
      best_of_samples = of_model;
      optimise_locally(fitter, score, sample, {model, squares, of_model}, keep);
    }
    if (!(best_score < before) || !score.may_end_search(best_score)) continue;
    const auto good = std::ranges::count_if(
        best->inliers, [&](std::size_t i) { return std::ranges::binary_search(usable, i); });
    const double share = static_cast<double>(good) / static_cast<double>(usable.size());
    wanted = sampler.count_for(std::max(share, options.least_share));
  }
  if (best) best->num_samples = count;
  return best;
}

// Sum of the squares truncated at the square of a tolerance (MSAC: Torr & Zisserman, CVIU 2000),
// where the noise is known.
struct TruncatedSquares {
  double tolerance_square;

  double operator()(std::span<const double> squares) const {
    double sum = 0;
    for (const double square : squares) sum += std::min(square, tolerance_square);
    return sum;
  }
  double inlier_square(double) const { return tolerance_square; }
  bool may_end_search(double) const { return true; }
};

}  // namespace tagcal::internal
