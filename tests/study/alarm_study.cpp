// How often tissued's alarm is raised where nothing is missing, and how soon where something is.
// usage: alarm_study nulls HOURS SEED          sessions of five minutes, each of a body of its own
//        alarm_study twins COUNT SEED          of every kind, a minute each
//        alarm_study recordings BUNDLE...      all trials of each, one after the other          run by scripts/alarm
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "core/effects/effect.hpp"
#include "daemon/recording.hpp"
#include "daemon/scene_loader.hpp"
#include "daemon/trial_run.hpp"
#include "tests/study/alarm_session.hpp"
#include "tests/study/null_summary.hpp"

namespace {

using namespace tissued;
using namespace tissued::study;

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// By two threads, in no order; `work` is handed a number from 0 on until it returns false.
template <typename Work>
void share_out(Work work) {
  std::atomic<int> next{0};
  const auto run = [&] {
    while (work(next++)) {
    }
  };
  const unsigned threads = std::max(1u, std::min(2u, std::thread::hardware_concurrency()));
  std::vector<std::jthread> helpers;
  for (unsigned k = 1; k < threads; ++k) helpers.emplace_back(run);
  run();
}

// What must not be above 1 for the threshold to hold what it promises: see core::MismatchAlarm.
double mean_exponential(const std::vector<double>& evidences) {
  double sum = 0.0;
  for (double evidence : evidences) sum += std::exp(evidence);
  return evidences.empty() ? 0.0 : sum / static_cast<double>(evidences.size());
}

struct Nulls {
  double hours = 0.0;
  int alarms = 0, sessions = 0, sessions_with = 0;
};

// 95 % of a rate of Poisson events: by the quantiles of chi square (Garwood 1936), solved by bisection.
double poisson_below(int count, double mean) {
  double term = std::exp(-mean), sum = term;
  for (int k = 1; k <= count; ++k) sum += term *= mean / k;
  return sum;
}
Interval poisson_interval(int count) {
  const auto solve = [](auto&& is_low) {
    double low = 0.0, high = 1e4;
    for (int k = 0; k < 100; ++k) (is_low(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    return low;
  };
  return {count == 0 ? 0.0 : solve([&](double m) { return 1.0 - poisson_below(count - 1, m) < 0.025; }),
          solve([&](double m) { return poisson_below(count, m) > 0.025; })};
}

int nulls(double hours, std::uint64_t seed) {
  constexpr double kSeconds = 300.0;
  const int sessions = std::max(1, static_cast<int>(std::lround(hours * 3600.0 / kSeconds)));
  Nulls total;
  std::mutex mutex;
  std::printf(
      "seed,shape,tets,markers,pads,depth_mm,nu,alarms,raised_s,level,draws,mean_exp,ratio_50,ratio_90,ratio_max,"
      "misfit_90,"
      "elements_90,misfit_of_load\n");
  share_out([&](int k) {
    if (k >= sessions) return false;
    const std::uint64_t own = seed + static_cast<std::uint64_t>(k);
    Random random(own);
    std::optional<std::vector<PushCurve>> curves;
    WatchedBody body;
    while (!curves) {
      body = draw_body(random);
      curves = solve_pushes(body);
    }
    const AlarmRun run = play_null(body, *curves, kSeconds, 1000 * own);
    double deepest = 0.0;
    for (const Push& push : body.pushes)
      deepest = std::max(deepest, *std::max_element(push.depths.begin(), push.depths.end()));
    const std::lock_guard lock(mutex);
    total.hours += run.seconds / 3600.0;
    total.alarms += run.raised;
    ++total.sessions;
    total.sessions_with += run.raised > 0 ? 1 : 0;
    std::printf("%llu,%s,%d,%zu,%zu,%.1f,%.3f,%d,%.0f,%.2f,%zu,%.2f,%.2f,%.2f,%.2f,%.3f,%.3f,%.4f\n",
                static_cast<unsigned long long>(own), body.shape.c_str(), body.scene.mesh.tet_count(),
                body.scene.markers.size(), body.scene.pads.size(), deepest, body.scene.material.poissons_ratio,
                run.raised, run.raised_seconds, run.highest_level, run.ratios.size(), mean_exponential(run.evidences),
                quantile(run.ratios, 0.5), quantile(run.ratios, 0.9), quantile(run.ratios, 1.0),
                quantile(run.misfits, 0.9), quantile(run.elements, 0.9),
                quantile(run.misfits, 0.9) / quantile(run.loads, 0.9));
    std::fflush(stdout);
    return true;
  });
  const Interval rate = poisson_interval(total.alarms);
  const Interval share = clopper_pearson(total.sessions_with, total.sessions);
  std::printf(
      "%d false alarms in %.1f h: %.3f an hour, 95 %% interval %.3f to %.3f; in %d of %d sessions (%.1f to %.1f %%)\n",
      total.alarms, total.hours, total.alarms / total.hours, rate.low / total.hours, rate.high / total.hours,
      total.sessions_with, total.sessions, 100.0 * share.low, 100.0 * share.high);
  return 0;
}

core::EffectSetting setting(const core::Scene& scene, const std::string& kind,
                            const std::map<std::string, double>& numbers) {
  const core::Effect* effect = core::find_effect(kind);
  core::EffectSetting setting{effect, effect->neutral(scene)};
  for (const auto& [name, value] : numbers)
    for (std::size_t k = 0; k < setting.values.size(); ++k)
      if (effect->parameters()[k].name == name) setting.values[k] = value;
  return setting;
}

// One of each kind, as strong as such things are: a lump under a pad, a base that is loose below it, half of the stress
// lost, a skin as stiff as three millimetres of the tissue.
std::map<std::string, Twin> twins_of(const WatchedBody& body, Random& random) {
  const core::Scene& scene = body.scene;
  const core::Vec3 size = (scene.mesh.rest.colwise().maxCoeff() - scene.mesh.rest.colwise().minCoeff()).transpose();
  const core::Pad& pad = scene.pads.front();
  const core::Vec3 under = pad.center + 0.4 * size.z() * pad.direction;
  const double stiffness = scene.material.youngs_modulus;
  std::map<std::string, Twin> twins;
  twins["none"] = Twin{};
  const auto add = [&](const std::string& kind, const std::map<std::string, double>& numbers) {
    twins[kind].effects = {setting(scene, kind, numbers)};
  };
  add("inclusion", {{"center.x", under.x()},
                    {"center.y", under.y()},
                    {"center.z", under.z()},
                    {"radius", 0.3 * size.z()},
                    {"ratio", 6.0}});
  add("loose-base", {{"center.x", pad.center.x()},
                     {"center.y", pad.center.y()},
                     {"center.z", 0.0},
                     {"radius", 0.3 * size.x()},
                     {"looseness", 1.0},
                     {"normal_held", 0.0}});
  add("gravity", {{"gravity.x", 0.7}, {"gravity.y", 0.0}, {"gravity.z", -0.7}});
  add("skin", {{"stiffness", 3.0 * stiffness}});
  add("viscoelasticity", {{"g1", 0.5}, {"tau1", 0.7}});
  add("strain-stiffening", {{"b", 4.0}});
  for (const char* kind : {"swelling", "sliding-actuator", "softening", "anisotropy", "stiffness-gradient"}) {
    const core::Effect* effect = core::find_effect(kind);
    const std::vector<std::vector<double>> starts = effect->starts(scene);
    std::vector<double> values = starts.empty() ? effect->neutral(scene) : starts.front();
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::string& name = effect->parameters()[k].name;
      if (std::string(kind) == "anisotropy" && name == "k") values[k] = 2.0 * stiffness;
      // From one end to the other by a factor of 5.
      if (std::string(kind) == "stiffness-gradient" && name.starts_with("slope.x")) values[k] = 1.6 / size.x();
    }
    twins[kind].effects = {{effect, values}};
  }
  twins["latency"].faults.latency = 0.05;
  twins["registration"].faults.rotation = 0.05 * random.normal_vector().normalized();
  const int marker = random.integer(0, static_cast<int>(body.scene.markers.size()) - 1);
  twins["marker-slip"].faults.slips = {{marker, 0, 20.0, 4.0 * random.normal_vector().normalized()}};
  return twins;
}

int twins(int count, std::uint64_t seed) {
  constexpr double kSeconds = 60.0;
  struct Row {
    std::vector<double> delays, misfits, places;
    int runs = 0;
  };
  std::map<std::string, Row> rows;
  std::mutex mutex;
  share_out([&](int k) {
    if (k >= count) return false;
    Random random(seed + static_cast<std::uint64_t>(k));
    const WatchedBody body = draw_body(random);
    for (const auto& [kind, twin] : twins_of(body, random)) {
      const auto run = play_twin(body, twin, kSeconds, 1000 * (seed + static_cast<std::uint64_t>(k)));
      if (!run) continue;
      const std::lock_guard lock(mutex);
      Row& row = rows[kind];
      ++row.runs;
      row.misfits.push_back(run->misfit);
      const double begin = kind == "marker-slip" ? 20.0 : run->first_push;
      if (run->alarm.first_raised >= 0.0) row.delays.push_back(run->alarm.first_raised - begin);
      if (run->alarm.place && !twin.effects.empty() &&
          twin.effects.front().effect->parameters().front().name == "center.x") {
        const auto& v = twin.effects.front().values;
        row.places.push_back((*run->alarm.place - core::Vec3(v[0], v[1], v[2])).norm());
      }
      std::fprintf(stderr, "%d %s: raised %.1f s, level %.2f, misfit %.2f mm, ratio %.2f\n", k, kind.c_str(),
                   run->alarm.first_raised, run->alarm.highest_level, run->misfit, quantile(run->alarm.ratios, 0.9));
    }
    return true;
  });
  std::printf("%-20s %6s %10s %12s %12s %10s %10s\n", "kind", "runs", "raised", "delay p50 s", "delay p90 s",
              "misfit mm", "place mm");
  for (const auto& [kind, row] : rows)
    std::printf("%-20s %6d %10zu %12.1f %12.1f %10.2f %10.1f\n", kind.c_str(), row.runs, row.delays.size(),
                quantile(row.delays, 0.5), quantile(row.delays, 0.9), quantile(row.misfits, 0.5),
                quantile(row.places, 0.5));
  return 0;
}

int recordings(int count, char** folders) {
  for (int k = 0; k < count; ++k) {
    const config::DaemonConfig config = config::config_for_bundle(folders[k]);
    const core::Scene scene = daemon::load_scene(config.bundle);
    daemon::TrialRunner runner(config, scene);
    double seconds = 0.0, first = -1.0, level = 0.0;
    int raised = 0;
    bool was = false;
    for (const config::TrialInfo& trial : config.bundle.trials) {
      const daemon::Recording recording(config.bundle, trial, daemon::read_trial(trial.file));
      for (const daemon::RunFrame& frame : runner.run(recording, daemon::recorded_order(recording))) {
        seconds += 1.0 / recording.rate_hz();
        level = std::max(level, frame.alarm.level);
        if (frame.alarm.raised && !was) {
          ++raised;
          if (first < 0.0) first = seconds;
          std::printf("  %s at %.1f s: level %.2f, misfit %.2f mm, place %.0f %.0f %.0f\n", trial.name.c_str(),
                      frame.time, frame.alarm.level, frame.alarm.misfit, frame.alarm.place[0], frame.alarm.place[1],
                      frame.alarm.place[2]);
        }
        was = frame.alarm.raised;
      }
    }
    std::printf("%s: raised %d times in %.0f s, first after %.1f s, highest level %.2f\n", folders[k], raised, seconds,
                first, level);
  }
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  const std::string what = count > 1 ? arguments[1] : "";
  try {
    if (what == "nulls" && count == 4) return nulls(std::stod(arguments[2]), std::stoull(arguments[3]));
    if (what == "twins" && count == 4) return twins(std::stoi(arguments[2]), std::stoull(arguments[3]));
    if (what == "recordings" && count > 2) return recordings(count - 2, arguments + 2);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "alarm_study: %s\n", error.what());
    return 1;
  }
  std::fprintf(stderr, "usage: alarm_study nulls HOURS SEED | twins COUNT SEED | recordings BUNDLE...\n");
  return 2;
}
