// What is wrong between a simulation and recordings, in numbers and in words: the contract of `diagnose`.
#pragma once

#include <string>
#include <vector>

#include "core/diagnosis/comparison.hpp"
#include "core/diagnosis/finding.hpp"
#include "core/diagnosis/search.hpp"

namespace tissued::core {

enum class Verdict { no_mismatch, parameters, measurement, missing_physics, unexplained };
std::string_view name_of(Verdict verdict);  // of the contract: no-mismatch, ...

struct Alternative {
  std::string kind;  // one kind, or two joined by " + "
  double probability = 0.0;
  double chi_square = 0.0;  // of its fit
};

// What a verdict rests on, against the thresholds of diagnosis.cpp.
struct Grounds {
  std::string likeliest;       // of single kinds; empty: none could be fitted
  double advantage = 0.0;      // of that one over numbers alone
  std::string likeliest_pair;  // empty: none was looked at closely
  double pair_gain = 0.0;      // of that one over its better half
  double structure = 0.0;      // left in the markers by the model that was chosen; 1: nothing but noise
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
  Grounds grounds;
  std::string next_experiment;  // empty: none is needed
  double seconds = 0.0;
  bool complete = true;              // false: stopped before its end
  std::vector<std::string> remarks;  // what a reader should know: no forces, gaps, what could not be tried

  std::vector<TrialCourse> courses;
  std::vector<MarkerMisfit> markers;
  // (tets of the scene's mesh) how much of the misfit a stiffness that differs in that element alone would explain, or,
  // where nothing known does, a force or pressure there; 0 to 1 of the largest; empty where there is nothing to
  // explain.
  std::vector<double> mismatch_map;

  // The model that was chosen, for predict and for tissued.
  Candidate explained;
  Eigen::VectorXd offset;  // (channels) mm: how far markers sit from where the scene has them
};

// What is said of what a search has found in a session, which is to be the search's. Throws as diagnose does.
Diagnosis conclude(const RecordedSession& session, const SearchResult& result, int threads);

// Compares a session with the physics that its scene assumes. Never throws for what recordings hold; ModelError where
// the scene cannot be simulated.
Diagnosis diagnose(const RecordedSession& session, const SearchOptions& options);

}  // namespace tissued::core
