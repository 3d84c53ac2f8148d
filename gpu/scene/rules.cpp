#include "gpu/scene/rules.hpp"

#include <algorithm>
#include <vector>

#include "gpu/base/keys.hpp"
#include "gpu/base/text.hpp"
#include "gpu/contacts/kinds.hpp"
#include "gpu/positions/format.hpp"
#include "gpu/tables/exclusions.hpp"

namespace collided {
namespace {

void check_length(const std::string& field, double value, double limit) {
  if (!(value >= 0 && value <= limit))
    throw InvalidInput(field, field + " is " + text(value) + "; it must be from 0 to " + text(limit));
}

void check_settings(const SceneSpec& spec, const FrameSettings& settings) {
  if (spec.quantized_in && settings.accuracy == Accuracy::kExact)
    throw InvalidInput(
        "quantized_in",
        "quantized_in is given, but EXACT needs exact positions; CERTIFIED counts the error of encoded ones");
  if (spec.kinds.triangle_triangle && settings.is_ccd() && settings.accuracy != Accuracy::kCandidates)
    throw InvalidInput(
        "triangle_triangle",
        "triangle_triangle is on, but only DCD tests triangle pairs; CCD lists them at CANDIDATES alone");
  if (spec.kinds.edge_triangle && settings.accuracy == Accuracy::kCandidates && !settings.is_ccd())
    throw InvalidInput("edge_triangle", "edge_triangle is on, but CANDIDATES decides of no pair whether it crosses");
  if (spec.kinds.vertex_solid && settings.accuracy == Accuracy::kCandidates && !settings.is_ccd())
    throw InvalidInput("vertex_solid", "vertex_solid is on, but CANDIDATES decides of no vertex whether it is inside");
  check_length("delta", settings.delta, coordinate_limit(spec.scalar));
  if (settings.report == Report::kEarliestOnly && (!settings.is_ccd() || settings.accuracy < Accuracy::kGuarded))
    throw InvalidInput("report", "report is EARLIEST_ONLY, which needs CCD at GUARDED or above");
  if (settings.report == Report::kAnyHit && settings.accuracy < Accuracy::kFast)
    throw InvalidInput("report", "report is ANY_HIT, which needs FAST or above");
}

void check_quantization(const SceneSpec& spec) {
  const double limit = coordinate_limit(spec.scalar);
  for (size_t i = 0; i < 3; ++i) {
    const double lower = spec.quantized_in->lower[i], upper = spec.quantized_in->upper[i];
    const std::string axis(1, "xyz"[i]);
    if (!(lower >= -limit && lower <= upper && upper <= limit))
      throw InvalidInput("quantized_in", "quantized_in is from " + text(lower) + " to " + text(upper) + " in " + axis +
                                             "; both must be from -" + text(limit) + " to " + text(limit) +
                                             ", and the first no more than the second");
  }
  if (spec.scalar != Scalar::kF32)
    throw InvalidInput("quantized_in", "quantized_in is given, which needs F32 positions");
  if (spec.kinds.triangle_triangle && spec.mode == Mode::kDcd)
    throw InvalidInput("triangle_triangle",
                       "triangle_triangle is on, but of encoded positions nobody can tell which "
                       "triangles intersect");
  if (spec.kinds.edge_triangle)
    throw InvalidInput(
        "edge_triangle",
        "edge_triangle is on, but of encoded positions nobody can tell which edges go through triangles");
  if (spec.kinds.vertex_solid)
    throw InvalidInput("vertex_solid",
                       "vertex_solid is on, but of encoded positions nobody can tell which vertices are inside");
  if (spec.pair_states)
    throw InvalidInput("pair_states", "pair_states is on, but of encoded positions nobody can tell what meets");
}

std::string name_of(Mode mode) { return mode == Mode::kDcd ? "DCD" : mode == Mode::kCcd ? "CCD" : "DCD_AND_CCD"; }

void check_mode(const SceneSpec& spec, const std::optional<Mode>& mode) {
  if (!mode) return;
  if (*mode == Mode::kBoth) throw InvalidInput("mode", "mode is DCD_AND_CCD, but a frame asks for one of them");
  if (spec.mode != Mode::kBoth && *mode != spec.mode)
    throw InvalidInput("mode",
                       "mode is " + name_of(*mode) + ", but the scene detects " + name_of(spec.mode) + " alone");
}

void check_advance(const SceneSpec& spec, const FrameSettings& settings) {
  if (!settings.is_ccd() || settings.accuracy < Accuracy::kCertified)
    throw InvalidInput("advance", "advance is on, which needs CCD at CERTIFIED or above");
  if (!spec.kinds.vertex_triangle || !spec.kinds.edge_edge)
    throw InvalidInput("advance", "advance is on, which needs both vertex-triangle and edge-edge contacts");
}

std::string text_of(const std::array<uint32_t, 2>& meshes) {
  return "meshes " + text(meshes[0]) + " and " + text(meshes[1]);
}

void check_excluded_meshes(const SceneSpec& spec) {
  const auto field_of = [](size_t i) { return "excluded_meshes[" + text(i) + "]"; };
  std::vector<std::pair<uint64_t, size_t>> keys;  // of each pair, and where it is
  for (size_t i = 0; i < spec.excluded_meshes.size(); ++i) {
    const auto [low, high] = std::minmax(spec.excluded_meshes[i][0], spec.excluded_meshes[i][1]);
    if (high >= spec.meshes.size())
      throw InvalidInput(field_of(i), field_of(i) + " is " + text_of(spec.excluded_meshes[i]) +
                                          ", but the last mesh is " + text(spec.meshes.size() - 1));
    keys.emplace_back(pack_ids(low, high), i);
  }
  std::sort(keys.begin(), keys.end());
  for (size_t k = 1; k < keys.size(); ++k) {
    const size_t again = keys[k].second;
    if (keys[k].first == keys[k - 1].first)
      throw InvalidInput(field_of(again), field_of(again) + " is " + text_of(spec.excluded_meshes[again]) +
                                              ", which an earlier pair already is");
  }
}

void check_start_fraction(const FrameSettings& settings, double fraction) {
  if (!settings.is_ccd()) throw InvalidInput("start_fraction", "start_fraction is given, which needs CCD");
  if (!(fraction >= 0 && fraction <= 1))
    throw InvalidInput("start_fraction", "start_fraction is " + text(fraction) + "; it must be from 0 to 1");
}

/// An edit counts with its frame, and its meshes have no way of a last one.
void check_edit(const FrameInput& frame) {
  if (frame.trial) throw InvalidInput("edit", "edit is given in a trial frame, which leaves the scene as it was");
  if (frame.start_fraction)
    throw InvalidInput("edit", "edit is given with start_fraction, but an edited scene has no last way to begin on");
  if (frame.slot != nullptr)
    throw InvalidInput("slot",
                       "slot is given with an edit, whose positions come in updates: it is of the scene before");
}

/// What is of the whole scene, and would be one world's alone.
void check_frame_of_worlds(const FrameInput& frame, const FrameSettings& settings) {
  const auto refuse = [](const char* field) {
    throw InvalidInput(field,
                       std::string(field) + " is given, but the scene is a set of worlds, whose frames have none");
  };
  if (settings.report != Report::kAll)
    throw InvalidInput("report", "report is not ALL, which the frames of a set of worlds have");
  if (frame.edit) refuse("edit");
  if (frame.advance) refuse("advance");
  if (frame.trial) refuse("trial");
  if (frame.start_fraction) refuse("start_fraction");
  if (!frame.room.memory.empty()) refuse("room");
}

void check_worlds(const SceneSpec& spec) {
  if (spec.worlds > kMaxWorlds)
    throw InvalidInput("worlds", "worlds is " + text(spec.worlds) + ", the limit is " + text(kMaxWorlds));
  if (spec.engine != Engine::kAuto && spec.engine != Engine::kLbvh)
    throw InvalidInput("engine", "engine is neither AUTO nor LBVH, which are those of a set of worlds");
  if (spec.reuse == Reuse::kOn)
    throw InvalidInput("reuse", "reuse is ON, but a set of worlds has no lists of neighbours");
  check_frame_of_worlds({}, settings_of(spec, {}));
}

void check_parts(const SceneSpec& spec) {
  if (spec.part_devices.size() > kMaxShards)
    throw InvalidInput("part_devices", "part_devices has " + text(spec.part_devices.size()) + " parts, the limit is " +
                                           text(kMaxShards));
  if (spec.worlds > 0)
    throw InvalidInput("part_devices", "part_devices has " + text(spec.part_devices.size()) +
                                           " parts, but a set of worlds is on one device");
  for (size_t k = 1; k < spec.part_devices.size(); ++k) {
    const Device &first = spec.part_devices[0], &other = spec.part_devices[k];
    const std::string field = "part_devices[" + text(k) + "]";
    if (other.backend != first.backend)
      throw InvalidInput(field, field + " is " + to_string(other) + ", but the first is " + to_string(first) +
                                    ": parts are on one backend");
  }
  if (spec.reuse == Reuse::kOn)
    throw InvalidInput("reuse", "reuse is ON, but a scene in parts has no lists of neighbours");
}

/// Whether what is asked of solids has any.
void check_solids(const SceneSpec& spec) {
  const auto refuse = [](const char* field) {
    throw InvalidInput(field, std::string(field) + " is on, but no mesh is a solid");
  };
  if (has_solids(spec)) return;
  if (spec.kinds.vertex_solid) refuse("vertex_solid");
  if (spec.pair_states) refuse("pair_states");
}

/// Of a mesh of a set of worlds.
void check_mesh_of_worlds(const MeshSpec& mesh, const std::string& field) {
  if (mesh.motion == MeshMotion::kRigid)
    throw InvalidInput(field + ".motion", field + ".motion is RIGID, which no mesh of a set of worlds is");
  if (mesh.excludes_rest_pairs)
    throw InvalidInput(field + ".excludes_rest_pairs",
                       field + ".excludes_rest_pairs is on, which no mesh of a set of worlds has");
}

void check_room(const ContactRoom& room) {
  const auto address = reinterpret_cast<uintptr_t>(room.memory.data());
  if (address % ContactRoom::kAlignment != 0)
    throw InvalidInput("room", "room begins at an address that is " + text(address % ContactRoom::kAlignment) +
                                   " above a multiple of " + text(ContactRoom::kAlignment));
}

void check_stream(const SceneSpec& spec, const FrameInput& frame) {
  const auto refuse = [](const char* reason) {
    throw InvalidInput("stream", std::string("stream is given, but ") + reason);
  };
  if (device_of(spec).backend != Backend::kCuda) refuse("the scene is on CPU cores, which have none");
  if (!spec.part_devices.empty()) refuse("a scene in parts is on several devices");
  if (frame.slot != nullptr) refuse("a slot has brought the positions already");
}

}  // namespace

void check_frame(const SceneSpec& spec, const FrameInput& frame) {
  check_mode(spec, frame.mode);
  const FrameSettings settings = settings_of(spec, frame);
  check_settings(spec, settings);
  if (frame.ignore_separating && (!settings.is_ccd() || settings.accuracy < Accuracy::kGuarded))
    throw InvalidInput("ignore_separating", "ignore_separating is on, which needs CCD at GUARDED or above");
  if (frame.advance) check_advance(spec, settings);
  if (!frame.advance && frame.advance_mode != AdvanceMode::kAllOrOne)
    throw InvalidInput("advance_mode", "advance_mode is given, but advance is off");
  if (!frame.advance && frame.limits) throw InvalidInput("limits", "limits is on, but advance is off");
  if (frame.start_fraction) check_start_fraction(settings, *frame.start_fraction);
  if (frame.edit)
    check_edit(frame);
  else
    check_distances(spec, settings);
  check_room(frame.room);
  if (!spec.part_devices.empty() && !frame.room.memory.empty())
    throw InvalidInput("room", "room is given, but the contacts of a scene in parts come to the host");
  if (frame.stream != nullptr) check_stream(spec, frame);
  if (spec.worlds > 0) check_frame_of_worlds(frame, settings);
}

namespace {

/// Self contacts are left out of meshes that have none: of each option the first such mesh is named.
void add_unused_exclusions(const SceneSpec& spec, std::vector<std::string>& unused) {
  const auto add_first = [&](const char* option, const auto& is_set) {
    for (size_t mesh = 0; mesh < spec.meshes.size(); ++mesh)
      if (!spec.meshes[mesh].self_contacts && is_set(spec.meshes[mesh]))
        return unused.push_back("meshes[" + std::to_string(mesh) + "]." + option);
  };
  add_first("excluded_rings", [](const MeshSpec& mesh) { return mesh.excluded_rings > 0; });
  add_first("excludes_rest_pairs", [](const MeshSpec& mesh) { return mesh.excludes_rest_pairs; });
}

}  // namespace

std::vector<std::string> unused_options(const SceneSpec& spec, const FrameInput& frame) {
  const FrameSettings settings = settings_of(spec, frame);
  std::vector<std::string> unused;
  if (spec.min_separation > 0 && spec.mode == Mode::kCcd && !frame.advance) unused.push_back("min_separation");
  if (spec.thickness > 0 && !is_of_features(first_of(spec.kinds))) unused.push_back("thickness");
  const auto is_thick = [](const MeshSpec& mesh) { return mesh.half_thickness > 0; };
  if (const auto thick = std::find_if(spec.meshes.begin(), spec.meshes.end(), is_thick);
      thick != spec.meshes.end() && !is_of_features(first_of(spec.kinds)))
    unused.push_back("meshes[" + std::to_string(thick - spec.meshes.begin()) + "].half_thickness");
  if (spec.delta > 0 && !frame.delta && settings.accuracy < Accuracy::kGuarded) unused.push_back("delta");
  add_unused_exclusions(spec, unused);
  return unused;
}

void check_spec(const SceneSpec& spec) {
  check_length("thickness", spec.thickness, coordinate_limit(spec.scalar));
  if (spec.kinds == PerKind<bool>{}) throw InvalidInput("kinds", "kinds are all off, nothing would be detected");
  if (spec.threads < 0)
    throw InvalidInput("threads", "threads is " + text(spec.threads) + ", the least is 0 (all cores)");
  if (const uint64_t longest = spec.expected.longest(); longest > kMaxListLength)
    throw InvalidInput("expected",
                       "expected has a list of " + text(longest) + ", the limit is " + text(kMaxListLength));
  check_length("min_separation", spec.min_separation, coordinate_limit(spec.scalar));
  check_rest_distance(spec);
  if (spec.min_separation > 0 && spec.mode == Mode::kDcd)
    throw InvalidInput("min_separation", "min_separation is " + text(spec.min_separation) + ", which needs CCD");
  if (spec.quantized_in) check_quantization(spec);
  if (spec.mode == Mode::kBoth && spec.kinds.triangle_triangle)
    throw InvalidInput("triangle_triangle", "triangle_triangle is on, which needs a scene of DCD or of CCD alone");
  if (spec.kinds.edge_triangle && spec.mode == Mode::kCcd)
    throw InvalidInput("edge_triangle", "edge_triangle is on, but edges go through triangles in frames of DCD alone");
  if (spec.kinds.vertex_solid && spec.mode == Mode::kCcd)
    throw InvalidInput("vertex_solid",
                       "vertex_solid is on, but vertices are looked for in solids in frames of DCD alone");
  if (spec.pair_states && spec.mode == Mode::kCcd)
    throw InvalidInput("pair_states", "pair_states is on, but frames of DCD alone tell how meshes lie to each other");
  if (spec.pair_states && spec.accuracy == Accuracy::kCandidates)
    throw InvalidInput("pair_states", "pair_states is on, but CANDIDATES decides of no pair whether it meets");
  if (spec.mode == Mode::kBoth && !is_of_features(first_of(spec.kinds)))
    throw InvalidInput("kinds", "kinds has neither vertex_triangle nor edge_edge, and frames of CCD have no others");
  check_settings(spec, settings_of(spec, {}));
  if (spec.worlds > 0) check_worlds(spec);
  if (!spec.part_devices.empty()) check_parts(spec);
}

void check_exclusions(const SceneSpec& spec) {
  const auto excludes = [](const MeshSpec& mesh) { return mesh.excludes_rest_pairs; };
  if (spec.rest_distance > 0 && std::none_of(spec.meshes.begin(), spec.meshes.end(), excludes))
    throw InvalidInput("rest_distance",
                       "rest_distance is " + text(spec.rest_distance) + ", but no mesh excludes rest pairs");
  for (size_t i = 0; i < spec.meshes.size(); ++i) check_mesh(spec, spec.meshes[i], "meshes[" + text(i) + "]");
  check_excluded_meshes(spec);
  check_solids(spec);
  check_distances(spec, settings_of(spec, {}));
}

void check_mesh(const SceneSpec& spec, const MeshSpec& mesh, const std::string& field) {
  const auto refuse_solid = [&](const std::string& where) {
    throw InvalidInput(field + ".solid", field + ".solid is on, but no mesh of " + where + " can be a solid");
  };
  if (mesh.solid && spec.worlds > 0) refuse_solid("a set of worlds");
  if (mesh.solid && !spec.part_devices.empty()) refuse_solid("a scene in parts");
  if (mesh.solid && spec.quantized_in) refuse_solid("encoded positions");
  if (spec.worlds > 0) check_mesh_of_worlds(mesh, field);
  check_length(field + ".half_thickness", mesh.half_thickness, coordinate_limit(spec.scalar));
  if (mesh.excluded_rings > kMaxRings)
    throw InvalidInput(field + ".excluded_rings",
                       field + ".excluded_rings is " + text(mesh.excluded_rings) + ", the limit is " + text(kMaxRings));
  if (mesh.excludes_rest_pairs && !is_of_features(first_of(spec.kinds)))
    throw InvalidInput(field + ".excludes_rest_pairs",
                       field +
                           ".excludes_rest_pairs is on, but the scene has triangle pairs alone: rest pairs are "
                           "vertex-triangle and edge-edge contacts");
}

void check_distances(const SceneSpec& spec, const FrameSettings& settings) {
  if (settings.is_ccd() || settings.accuracy != Accuracy::kFast || settings.thickness > 0) return;
  if (!is_of_features(first_of(spec.kinds))) return;
  const std::string needed = "; discrete detection at FAST needs a distance > 0";
  if (!settings.differs_by_pair()) throw InvalidInput("thickness", "thickness is 0" + needed);
  std::vector<bool> are_thin;
  for (const MeshSpec& mesh : spec.meshes) are_thin.push_back(mesh.half_thickness == 0);
  if (const auto pair = find_tested_pair(spec, are_thin))
    throw InvalidInput("thickness", "thickness is 0, and so is the half_thickness of " + text_of(*pair) + needed);
}

void check_rest_distance(const SceneSpec& spec) {
  check_length("rest_distance", spec.rest_distance, coordinate_limit(spec.scalar));
}

}  // namespace collided
