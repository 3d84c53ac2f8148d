// What the engine and the configuration know is told: no field of the answers is forgotten.
#include <gtest/gtest.h>

#include <set>

#include "server/convert/facts.hpp"
#include "server/convert/frame.hpp"
#include "tests/server/convert/scene_refusals.hpp"

namespace collided::server {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// The paths of fields that have their default, or no element; of the first element where there are several.
void add_untold(const Message& message, const std::string& path, std::set<std::string>& untold) {
  const auto& reflection = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor* const field = message.GetDescriptor()->field(i);
    const bool is_told =
        field->is_repeated() ? reflection.FieldSize(message, field) > 0 : reflection.HasField(message, field);
    const std::string name = path + std::string(field->name());
    if (!is_told)
      untold.insert(name);
    else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE)
      add_untold(field->is_repeated() ? reflection.GetRepeatedMessage(message, field, 0)
                                      : reflection.GetMessage(message, field),
                 name + ".", untold);
  }
}
std::set<std::string> untold_of(const Message& message) {
  std::set<std::string> untold;
  add_untold(message, "", untold);
  return untold;
}

// Those that are left are told by who sends the answer.
TEST(Told, AllThatTheEngineSaysOfAFrame) {
  FrameResult result;
  result.stages = {{"boxes", 1}};
  result.counts = {.cells = 1,
                   .leaves = 2,
                   .top_level = 3,
                   .base_level = 4,
                   .registrations = 5,
                   .tests = 6,
                   .pairs = 7,
                   .candidates = {8, 9, 10},
                   .contacts = {11, 12, 13, 18, 19},
                   .survivors = {14, 15, 16},
                   .exact_decisions = 17,
                   .inside_out = 20};
  result.replays = 1, result.allocations = 2, result.graph_launches = 3, result.step_milliseconds = 4;
  result.broad_phase = {Engine::kLbvh, EngineReason::kFaster, 5, 6, 7};
  result.reuse = {ListUse::kReused, ReuseReason::kFaster, 8, 9, 10, 11};
  result.shards = {{0.5, 12, 13, 14}};
  result.input_resolution = result.any_contact = true;
  result.earliest_toi = 0.25;
  result.advanced = 0.5, result.way = 0.75;
  result.shortened = {{3}, {0.5}};
  result.unused_options = {"min_separation"};
  result.placed.vertex_triangle.count = 3;
  pb::FrameDone done;
  fill_result(result, &done);
  EXPECT_EQ(untold_of(done),
            (std::set<std::string>{"contacts", "metrics.total_milliseconds", "metrics.queue_milliseconds",
                                   "metrics.device_bytes", "metrics.bytes_in", "metrics.bytes_out",
                                   "metrics.decode_milliseconds", "metrics.engine_milliseconds",
                                   "metrics.encode_milliseconds", "shortened", "limits", "pairs"}));
  EXPECT_EQ(done.contact_count(), 3u);
  EXPECT_EQ(done.advanced(), 0.5);
  EXPECT_EQ(done.way(), 0.75);
  const pb::FrameMetrics& metrics = done.metrics();
  EXPECT_EQ(metrics.stages(0).stage(), "boxes");
  EXPECT_EQ(metrics.unused_options(0), "spec.min_separation");
  EXPECT_EQ(metrics.stages(0).milliseconds(), 1);
  EXPECT_EQ(metrics.octree_milliseconds(), 5);
  EXPECT_EQ(metrics.lbvh_milliseconds(), 6);
  EXPECT_EQ(metrics.all_pairs_milliseconds(), 7);
  EXPECT_EQ(metrics.list_margin(), 8);
  EXPECT_EQ(metrics.list_frames(), 9u);
  EXPECT_EQ(metrics.list_milliseconds(), 10);
  EXPECT_EQ(metrics.search_milliseconds(), 11);
  EXPECT_EQ(metrics.parts(0).share(), 0.5);
  EXPECT_EQ(metrics.parts(0).step_milliseconds(), 12);
  EXPECT_EQ(metrics.parts(0).pairs(), 13u);
  EXPECT_EQ(metrics.parts(0).contacts(), 14u);
}

TEST(Told, HowFarAFrameWentOnlyWhereItAdvances) {
  pb::FrameDone done;
  fill_result({}, &done);
  EXPECT_FALSE(done.has_advanced() || done.has_way());
}

TEST(Told, AllLimits) {
  Limits limits;
  limits.max_scene_bytes = 1 << 20, limits.max_device_bytes = 2 << 20;
  ClientLimits client;
  client.max_scenes = 3, client.max_device_bytes = 4 << 20, client.max_streams = 5;
  pb::ServerLimits told;
  fill_limits(limits, client, &told);
  EXPECT_EQ(untold_of(told), std::set<std::string>());
  EXPECT_EQ(told.max_scene_bytes(), 1u << 20);
  EXPECT_EQ(told.max_device_bytes(), 2u << 20);
  EXPECT_EQ(told.max_scenes_per_client(), 3u);
  EXPECT_EQ(told.max_device_bytes_per_client(), 4u << 20);
  EXPECT_EQ(told.max_streams_per_client(), 5u);
  EXPECT_EQ(told.max_window(), limits.max_window);
}

TEST(Told, AllOfADevice) {
  pb::Device told;
  fill_device({{{Backend::kCuda, 1}, "name", 1, "uuid"}, 2, 3, 4, 5, 6, 7, 8}, &told);
  EXPECT_EQ(untold_of(told), std::set<std::string>());
  EXPECT_EQ(told.id(), "cuda:1");
  EXPECT_EQ(told.max_bytes(), 2u);
  EXPECT_EQ(told.free_bytes(), 4u);
  EXPECT_EQ(told.scenes(), 5u);
  EXPECT_EQ(told.load(), 6);
}

TEST(Told, WhatASceneIsMadeOf) {
  const auto wanted = request_with([](pb::SceneSpec& s) {
    s.set_display_name("the scene");
    s.set_accuracy(pb::ACCURACY_GUARDED);
    s.set_thickness(0.5);
    s.set_delta(0.25);
    s.set_min_separation(0.125);
  });
  const ScenePlan plan = parse_scene(wanted, {}).plan;
  EXPECT_EQ(plan.display_name, "the scene");
  EXPECT_EQ(plan.engine.thickness, 0.5);
  EXPECT_EQ(plan.engine.delta, 0.25);
  EXPECT_EQ(plan.engine.min_separation, 0.125);
  const pb::Scene told = shown(wanted);
  EXPECT_EQ(told.spec().display_name(), "the scene");
  EXPECT_EQ(told.spec().thickness(), 0.5);
  EXPECT_EQ(told.spec().delta(), 0.25);
  EXPECT_EQ(told.spec().min_separation(), 0.125);
  EXPECT_EQ(told.device_id(), "cpu:0");
}

}  // namespace
}  // namespace collided::server
