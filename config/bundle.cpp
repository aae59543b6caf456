#include "config/bundle.hpp"

#include <algorithm>

#include "config/document.hpp"
#include "config/geometry.hpp"
#include "config/schema.hpp"

namespace tissued::config {
namespace {

namespace fs = std::filesystem;

// A file that the bundle names stays inside the bundle.
fs::path file_in(const fs::path& folder, const Document& document, const JsonPointer& key) {
  const fs::path file = document.root().at(key).get<std::string>();
  const bool leaves = file.is_absolute() || std::find(file.begin(), file.end(), "..") != file.end();
  if (leaves) document.refuse(key, quoted(document.root().at(key)) + " leaves the bundle's folder");
  return folder / file;
}

fs::path find_mesh(const fs::path& folder, const Document& document) {
  const JsonPointer key("/mesh");
  const fs::path file = file_in(folder, document, key);
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) {
    document.refuse(key, quoted(document.root().at(key)) + " is not a file in " + folder.string());
  }
  return file;
}

core::Material read_material(const Document& document) {
  const Json& material = document.root()["material"];
  return {material["youngs_modulus"].get<double>(), material["poissons_ratio"].get<double>(),
          material["density"].get<double>()};
}

void read_pads(const Document& document, Bundle& bundle) {
  const Json* actuators = document.find("/actuators");
  if (!actuators) return;
  for (const auto& [name, pad] : actuators->items()) {
    const JsonPointer key = JsonPointer("/actuators") / name;
    if (pad["surface"] == bundle.scene.fixed_surface) {
      document.refuse(key / "surface", quoted(pad["surface"]) + " is the surface that is held still (/fixed)");
    }
    bundle.scene.pads.push_back({name, pad["surface"].get<std::string>(), to_vector(pad["center"]),
                                 to_unit_vector(document, key / "direction")});
    bundle.pad_shapes.push_back({to_unit_vector(document, key / "normal"), pad["radius"].get<double>()});
  }
}

core::ProbeShape read_probe_shape(const Document& document, const JsonPointer& key) {
  const Json& json = document.root().at(key);
  core::ProbeShape shape;
  if (json.contains("center")) shape.center = to_vector(json["center"]);
  shape.half_extents = to_vector(json["half_extents"]);
  shape.rounding = json.value("rounding", 0.0);
  if (const double smallest = shape.half_extents.minCoeff(); shape.rounding > smallest) {
    document.refuse(key / "rounding",
                    quoted(json["rounding"]) + " is above the smallest half extent " + quoted(Json(smallest)));
  }
  return shape;
}

std::optional<core::ImagePlane> read_probe_image(const Document& document, const JsonPointer& key) {
  const Json* json = document.find(key.to_string());
  if (!json) return std::nullopt;
  core::ImagePlane image;
  image.probe_T_image.rotation = to_rotation(document, key / "probe_T_image" / "rotation");
  image.probe_T_image.translation = to_vector((*json)["probe_T_image"]["translation"]);
  image.spacing = {(*json)["spacing"][0].get<double>(), (*json)["spacing"][1].get<double>()};
  image.size = {(*json)["size"][0].get<int>(), (*json)["size"][1].get<int>()};
  return image;
}

void read_probes(const Document& document, Bundle& bundle) {
  const Json* probes = document.find("/probes");
  if (!probes) return;
  constexpr std::size_t kObjects = 32;  // in a tracker frame
  const std::size_t actuators = bundle.scene.pads.size();
  if (actuators + probes->size() > kObjects) {
    document.refuse(JsonPointer("/probes"), std::to_string(probes->size()) + " beside " + std::to_string(actuators) +
                                                " of /actuators are more than the " + std::to_string(kObjects) +
                                                " objects that a tracker frame holds");
  }
  for (const auto& [name, probe] : probes->items()) {
    const JsonPointer key = JsonPointer("/probes") / name;
    if (document.root().contains(JsonPointer("/actuators") / name)) {
      document.refuse(key, "the name is given twice, here and in /actuators");
    }
    bundle.scene.probes.push_back({name, read_probe_shape(document, key / "shape"), probe.value("friction", 0.0)});
    bundle.probe_images.push_back(read_probe_image(document, key / "image"));
  }
}

// Pads, probes, markers and targets share the tracker's label space: a label says which of them it is.
void read_points(const Document& document, Bundle& bundle) {
  const auto refuse_namesake = [&](const JsonPointer& key, const std::string& name, const char* other) {
    if (document.root().contains(other) && document.root()[other].contains(name)) {
      document.refuse(key / name, "the name is given twice, here and in /" + std::string(other));
    }
  };
  for (const auto& [name, position] : document.root()["markers"].items()) {
    refuse_namesake(JsonPointer("/markers"), name, "actuators");
    refuse_namesake(JsonPointer("/markers"), name, "probes");
    bundle.scene.markers.push_back({name, to_vector(position)});
  }
  for (const auto& [name, position] : document.root()["targets"].items()) {
    refuse_namesake(JsonPointer("/targets"), name, "actuators");
    refuse_namesake(JsonPointer("/targets"), name, "probes");
    refuse_namesake(JsonPointer("/targets"), name, "markers");
    bundle.scene.targets.push_back({name, to_vector(position)});
  }
}

void read_marker_sets(const Document& document, Bundle& bundle) {
  const Json* sets = document.find("/marker_sets");
  if (!sets) return;
  const Json& markers = document.root()["markers"];
  for (const auto& [name, members] : sets->items()) {
    const JsonPointer key = JsonPointer("/marker_sets") / name;
    if (name == "all") document.refuse(key, "\"all\" always means every marker and cannot name a set");
    MarkerSet set{name, {}};
    for (std::size_t i = 0; i < members.size(); ++i) {
      const std::string marker = members[i].get<std::string>();
      if (!markers.contains(marker)) document.refuse(key / i, quoted(members[i]) + " is not one of /markers");
      set.markers.push_back(marker);
    }
    bundle.marker_sets.push_back(std::move(set));
  }
}

void read_trial_details(const Document& document, const JsonPointer& key, TrialInfo& trial) {
  const Json& details = document.root().at(key);
  trial.held_until_frame = details.value("held_until_frame", 0);
  if (const Json* end = document.find((key / "end_frame").to_string())) {
    trial.end_frame = end->get<int>();
    if (*trial.end_frame <= trial.held_until_frame) {
      document.refuse(key / "end_frame",
                      quoted(*end) + " is not above held_until_frame " + std::to_string(trial.held_until_frame));
    }
  }
  trial.start = details.value("start", "");
  if (!details.contains("loads")) return;
  for (const Json& load : details["loads"]) {
    trial.loads.push_back(
        {{to_vector(load["edge"][0]), to_vector(load["edge"][1])}, to_vector(load["force"]), load.value("mass", 0.0)});
  }
}

void read_trials(const Document& document, const fs::path& folder, Bundle& bundle) {
  for (const char* list : {"trials", "held_out"}) {
    if (!document.root().contains(list)) continue;
    const Json& names = document.root()[list];
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string name = names[i].get<std::string>();
      if (bundle.find_trial(name)) {
        document.refuse(JsonPointer() / list / i,
                        quoted(names[i]) + " is in /trials, too: what is fitted is not held out");
      }
      const JsonPointer details = JsonPointer("/trial") / name;
      TrialInfo trial;
      trial.name = name;
      trial.held_out = std::string_view(list) == "held_out";
      trial.file = document.root().contains(details / "file") ? file_in(folder, document, details / "file")
                                                              : folder / (name + ".csv");
      if (document.root().contains(details)) read_trial_details(document, details, trial);
      bundle.trials.push_back(std::move(trial));
    }
  }
  if (!document.find("/trial")) return;
  for (const auto& [name, ignored] : document.root()["trial"].items()) {
    if (!bundle.find_trial(name)) {
      document.refuse(JsonPointer("/trial") / name, "names no trial of /trials or /held_out");
    }
  }
}

void read_tracker_pose(const Document& document, Bundle& bundle) {
  const Json* pose = document.find("/world_from_tracker");
  if (!pose) return;
  bundle.has_tracker_pose = true;
  bundle.tissue_from_tracker.rotation = to_rotation(document, JsonPointer("/world_from_tracker/rotation"));
  if (pose->contains("translation")) bundle.tissue_from_tracker.translation = to_vector((*pose)["translation"]);
}

void read_noise(const Document& document, Bundle& bundle) {
  bundle.noise = {document.value("/noise/marker", 0.0), document.value("/noise/target", 0.0),
                  document.value("/noise/force", 0.0)};
  bundle.scene.marker_noise = bundle.noise.marker;
}

template <typename Named>
const Named* find_named(const std::vector<Named>& list, const std::string& name) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const Named& item) { return item.name == name; });
  return found == list.end() ? nullptr : &*found;
}

}  // namespace

const TrialInfo* Bundle::find_trial(const std::string& name) const { return find_named(trials, name); }

const MarkerSet* Bundle::find_marker_set(const std::string& name) const { return find_named(marker_sets, name); }

Bundle load_bundle(const fs::path& folder, std::span<const std::string> overrides) {
  const fs::path file = folder / "bundle.json";
  const Document document(read_json(file), file.string(), overrides, bundle_schema());
  Bundle bundle;
  bundle.folder = folder;
  bundle.mesh_file = find_mesh(folder, document);
  bundle.scene.name = document.value("/name", (folder / "").parent_path().filename().string());
  bundle.scene.material = read_material(document);
  bundle.scene.fixed_surface = document.value<std::string>("/fixed", "");
  bundle.scene.skin_surface = document.value<std::string>("/surface", "");
  if (const Json* gravity = document.find("/gravity")) bundle.scene.gravity = to_vector(*gravity);
  bundle.scene.rate = document.value("/rate", 0.0);
  bundle.subject = document.value<std::string>("/subject", "");
  bundle.dynamic = document.value("/dynamic", false);
  read_noise(document, bundle);
  read_pads(document, bundle);
  read_probes(document, bundle);
  read_points(document, bundle);
  read_marker_sets(document, bundle);
  read_trials(document, folder, bundle);
  read_tracker_pose(document, bundle);
  return bundle;
}

}  // namespace tissued::config
