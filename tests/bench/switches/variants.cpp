#include "tests/bench/switches/variant.hpp"

namespace collided::test {
namespace {

using Send = Variant::Send;

void declare_static_ball(SceneSpec& spec) { spec.meshes[kBall].motion = MeshMotion::kStatic; }
void declare_rigid_ball(SceneSpec& spec) { spec.meshes[kBall].motion = MeshMotion::kRigid; }
void leave_out_cloth_self(SceneSpec& spec) { spec.meshes[kCloth].self_contacts = false; }

void nothing(SceneSpec&) {}

template <Accuracy accuracy>
void at(FrameInput& frame) {
  frame.accuracy = accuracy;
}
template <Report report>
void reporting(FrameInput& frame) {
  frame.report = report;
}

void find_near(SceneSpec& spec) {
  spec.mode = Mode::kDcd;
  spec.thickness = 0.005;
}

Variant declares(const char* name, void (*declare)(SceneSpec&), Send send = Send::kWhole, bool has_ball = true) {
  return {.name = name, .send = send, .declare = declare, .has_ball = has_ball};
}
Variant asks(const char* name, void (*ask)(FrameInput&), Send send = Send::kWhole) {
  return {.name = name, .send = send, .ask = ask};
}

std::vector<Variant> make_variants() {
  return {
      declares("full model", nothing),
      declares("cloth alone", nothing, Send::kClothAlone, false),
      declares("static ball", declare_static_ball, Send::kClothAlone),
      declares("rigid ball", declare_rigid_ball, Send::kBallByPose),
      declares("DCD alone", [](SceneSpec& s) { s.mode = Mode::kDcd; }),
      declares("DCD alone, and crossings",
               [](SceneSpec& s) {
                 s.mode = Mode::kDcd;
                 s.kinds.edge_triangle = true;
               }),
      declares("DCD alone, and triangle pairs",
               [](SceneSpec& s) {
                 s.mode = Mode::kDcd;
                 s.kinds.triangle_triangle = true;
               }),
      declares("DCD within 0.005", find_near),
      declares("DCD within 0.005, and crossings",
               [](SceneSpec& s) {
                 find_near(s);
                 s.kinds.edge_triangle = true;
               }),
      declares("DCD within 0.005, crossings and features",
               [](SceneSpec& s) {
                 find_near(s);
                 s.kinds.edge_triangle = true;
                 s.fields = s.fields.with(ContactField::kFeatures);
               }),
      declares("vertex-triangle alone", [](SceneSpec& s) { s.kinds = {.vertex_triangle = true}; }),
      declares("5 % of the vertices, sparse", nothing, Send::kFewVertices),
      declares(
          "Q16",
          [](SceneSpec& s) {
            s.quantized_in = PositionBox{{-4, -4, -8}, {4, 4, 4}};
          },
          Send::kQuantized),
      declares("F64", [](SceneSpec& s) { s.scalar = Scalar::kF64; }),
      declares("no self-contacts", leave_out_cloth_self),
      declares("2 rings excluded", [](SceneSpec& s) { s.meshes[kCloth].excluded_rings = 2; }),
      declares("rest pairs excluded",
               [](SceneSpec& s) {
                 s.meshes[kCloth].excludes_rest_pairs = true;
                 s.rest_distance = 0.01;
               }),
      // A frame that may leave the scene elsewhere says where it begins, so that it makes the others' step.
      declares("both ends sent", nothing, Send::kBothEnds),
      asks(
          "advance, both ends sent", [](FrameInput& frame) { frame.advance = true; }, Send::kBothEnds),
      asks(
          "trial, both ends sent", [](FrameInput& frame) { frame.trial = true; }, Send::kBothEnds),
      {.name = "edit of rules", .edit = Variant::Edit::kRules},
      {.name = "edit of the ball's triangles", .edit = Variant::Edit::kBall},
      asks("candidates", at<Accuracy::kCandidates>),
      asks("earliest contact", reporting<Report::kEarliestOnly>),
      asks("any contact", reporting<Report::kAnyHit>),
  };
}

}  // namespace

const std::vector<Variant>& variants() {
  static const std::vector<Variant> all = make_variants();
  return all;
}

}  // namespace collided::test
