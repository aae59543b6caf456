// What was found: its numbers, its place, when it shows; and where on the body the misfit sits.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/diagnosis/search.hpp"

namespace tissued::core {

struct FindingNumber {
  std::string name, unit;
  std::vector<double> value, sd;  // one, or x, y and z of a vector
};

struct Finding {
  std::string kind;  // of the contract
  double probability = 0.0;
  std::string title;    // in plain words, without numbers
  std::string summary;  // a sentence or two, with the numbers
  struct Place {
    Vec3 center;    // mm, tissue
    double radius;  // mm
  };
  std::optional<Place> where;
  std::vector<std::string> trials;  // in which it shows most
  std::string phase;                // push, hold, release, rest, throughout
  std::vector<FindingNumber> parameters;
};

// What a fit says of one of its kinds, but how likely it is and when it shows.
Finding finding_of(const std::string& kind, const Fit& fit, const Scene& scene);

// Sets the trials, and the phase, in which `after` explains most of what `before` does not.
void set_when(const FitData& data, const Fit& before, const Fit& after, Finding& finding);

// Likewise of what a fit leaves.
void set_when_left(const FitData& data, const Fit& fit, Finding& finding);

// How much of the misfit a lump would explain: nearest of the places that were tried, by how much each promised.
struct MismatchMap {
  std::vector<double> of_tet;  // 0 to 1; empty where no lump was tried
  Vec3 peak = Vec3::Zero();    // mm
  double radius = 0.0;         // mm
};
MismatchMap mismatch_map(const SearchResult& result, const Scene& scene);

}  // namespace tissued::core
