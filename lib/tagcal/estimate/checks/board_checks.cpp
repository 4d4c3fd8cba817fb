#include "tagcal/estimate/checks/board_checks.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

std::string number(double value) { return with_digits(value, 2); }

// A term of the board, if it is significant: "bent by 0.9 +- 0.1 mm along x".
void add_term(std::vector<std::string>& terms, const std::string& before, double value,
              double sigma, const std::string& after) {
  if (std::abs(value) > policy::kSignificant * sigma)
    terms.push_back(before + with_sigma(value, sigma) + after);
}

// A significant shape beyond what a board of its substrate has.
bool exceeds(double value, double sigma, double prior_sigma) {
  return std::abs(value) > policy::kSignificant * std::max(sigma, prior_sigma);
}

std::string made_of(const char* key, const Tolerance& tolerance) {
  if (const double* const share = std::get_if<double>(&tolerance))
    return std::string("a board of ") + key + " " + short_number(*share);
  return "a board of " + std::string(material_name(std::get<Material>(tolerance)));
}

// The end of a sentence about a board that contradicts its file.
std::string contradiction(const char* key, const Tolerance& tolerance, double prior_sigma,
                          const char* unit, const char* correct) {
  return ", more than " + made_of(key, tolerance) + " has (sd " + number(prior_sigma) + unit +
         "); the answer includes it, but correct " + correct +
         " in the target file, or take another board";
}

}  // namespace

std::optional<Finding> check_bend(const BoardWarp& board, const FlatBoard& flat) {
  std::vector<std::string> terms;
  add_term(terms, "bent by ", board.bend_mm.x(), board.sigma_mm.x(), " mm along x");
  add_term(terms, "bent by ", board.bend_mm.y(), board.sigma_mm.y(), " mm along y");
  add_term(terms, "twisted by ", board.twist_mm, board.sigma_twist_mm, " mm");
  if (terms.empty()) return std::nullopt;
  if (is_impossible(board, flat))
    return finding(code::board_bend_impossible,
                   "the corners fit a board " + listed(terms) +
                       ", more than a board can bend: the model is too small, or the target is "
                       "not as its file says");
  const double prior_mm = 1e3 * flat.prior_sigma[0];  // of bends and twist
  if (exceeds(board.bend_mm.x(), board.sigma_mm.x(), prior_mm) ||
      exceeds(board.bend_mm.y(), board.sigma_mm.y(), prior_mm) ||
      exceeds(board.twist_mm, board.sigma_twist_mm, prior_mm))
    return finding(code::flatness_exceeded, "the board is " + listed(terms) +
                                                contradiction("flatness", flat.substrate.flatness,
                                                              prior_mm, " mm", "`flatness`"));
  return finding(code::board_bent, "the board is " + listed(terms) + "; the answer includes it");
}

std::optional<Finding> check_print(const BoardWarp& board, const FlatBoard& flat) {
  std::vector<std::string> terms;
  add_term(terms, "", 100 * std::abs(board.aspect), 100 * board.sigma_aspect, " %");
  if (terms.empty()) return std::nullopt;
  const std::string sentence = std::string("the board is ") +
                               (board.aspect < 0 ? "shorter" : "longer") +
                               " along y than its file says, relative to x, by " + terms[0];
  const double prior = flat.prior_sigma[3];
  if (exceeds(board.aspect, board.sigma_aspect, prior))
    return finding(code::print_exceeded,
                   sentence + contradiction("print", flat.substrate.print, 100 * prior, " %",
                                            "the distances, or `print`,"));
  return finding(code::print_aspect, sentence + "; the answer includes it");
}

}  // namespace tagcal::internal
