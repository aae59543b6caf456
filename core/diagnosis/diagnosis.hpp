// What is wrong between a simulation and recordings, in numbers and in words: the contract of `diagnose`.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/diagnosis/search.hpp"

namespace tissued::core {

enum class Verdict { no_mismatch, parameters, measurement, missing_physics, unexplained };
std::string_view name_of(Verdict verdict);  // of the contract: no-mismatch, ...

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

struct Alternative {
  std::string kind;  // one kind, or two joined by " + "
  double probability = 0.0;
  double chi_square = 0.0;  // of its fit
};

// Root mean squares per axis over the seen frames; NaN where nothing was seen.
struct Misfit {
  double marker_mm = 0.0, target_mm = 0.0, force_N = 0.0;
};

// The three models that are compared: as assumed, with numbers refitted, with what was found.
struct Misfits {
  Misfit assumed, parameters, explained;
};

// One trial's course, for plots.
struct TrialCourse {
  std::string name;
  bool held_out = false;
  std::vector<double> time;                                     // (frames) s
  std::vector<double> load;                                     // (frames) mm
  std::vector<double> assumed_mm, parameters_mm, explained_mm;  // (frames) marker misfit, RMS per axis; NaN: none seen
  std::vector<double> force_seen_N, force_assumed_N, force_explained_N;  // (frames) largest pad force; empty: not seen
};

// A marker at the instant of a trial's largest load.
struct MarkerMisfit {
  std::string trial, marker;
  Vec3 rest, seen, assumed, explained;  // mm; rest in tissue coordinates, the others displacements
};

struct Diagnosis {
  std::string bundle;
  Verdict verdict = Verdict::no_mismatch;
  std::vector<Finding> findings;
  std::vector<Alternative> alternatives;
  Misfits trials, held_out;
  bool held_out_seen = false;  // the held-out recordings hold more than pads
  double noise_marker_mm = 0.0, noise_force_N = 0.0;
  double discretisation_marker_mm = 0.0;
  std::string next_experiment;  // empty: none is needed
  double seconds = 0.0;
  bool complete = true;              // false: stopped before its end
  std::vector<std::string> remarks;  // what a reader should know: no forces, gaps, what could not be tried

  std::vector<TrialCourse> courses;
  std::vector<MarkerMisfit> markers;
  // (tets of the scene's mesh) how much of the misfit a stiffness that differs in that element alone would explain,
  // 0 to 1 of the largest; empty where there is nothing to explain.
  std::vector<double> mismatch_map;

  // The model that was chosen, for predict and for tissued.
  Candidate explained;
  Eigen::VectorXd offset;  // (channels) mm: how far markers sit from where the scene has them
};

// Compares a session with the physics that its scene assumes. Never throws for what recordings hold; ModelError where
// the scene cannot be simulated.
Diagnosis diagnose(const RecordedSession& session, const SearchOptions& options);

// (frames x channels) what a model, open loop, would have recorded in a trial; by quadratic elements. Throws ModelError
// where the body has no equilibrium on the way.
RowMatrix predict(const Scene& scene, const RecordedTrial& trial, const Candidate& model,
                  const Eigen::VectorXd& offset);

}  // namespace tissued::core
