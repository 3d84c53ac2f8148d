// Fields of a frame and options that set them, of which neither may lack one that the other has.
#include "client/cpp/frame_options.hpp"

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace collided::client {
namespace {

/// A frame whose fields are all set, by the protocol's own description.
v1::Frame full_frame() {
  using google::protobuf::FieldDescriptor;
  v1::Frame frame;
  const auto& values = *v1::Frame::GetReflection();
  const auto& type = *v1::Frame::descriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor* const field = type.field(i);
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_BOOL:
        values.SetBool(&frame, field, true);
        break;
      case FieldDescriptor::CPPTYPE_DOUBLE:
        values.SetDouble(&frame, field, 0.5);
        break;
      case FieldDescriptor::CPPTYPE_ENUM:
        values.SetEnumValue(&frame, field, 1);
        break;
      case FieldDescriptor::CPPTYPE_UINT32:
        values.AddUInt32(&frame, field, 7);
        break;
      case FieldDescriptor::CPPTYPE_UINT64:
        values.SetUInt64(&frame, field, 7);
        break;
      default:
        if (field->is_repeated())
          values.AddMessage(&frame, field);
        else
          values.MutableMessage(&frame, field);
    }
  }
  return frame;
}

std::vector<std::string> missing_fields(const v1::Frame& frame) {
  std::vector<std::string> names;
  const auto& type = *v1::Frame::descriptor();
  std::vector<const google::protobuf::FieldDescriptor*> found;
  v1::Frame::GetReflection()->ListFields(frame, &found);
  for (int i = 0; i < type.field_count(); ++i)
    if (std::find(found.begin(), found.end(), type.field(i)) == found.end()) names.push_back(type.field(i)->name());
  return names;
}

TEST(FrameOptions, AHeadIsCopiedWithEveryFieldButTheUpdates) {
  v1::Frame frame = full_frame(), head;
  EXPECT_EQ(missing_fields(frame), std::vector<std::string>());
  copy_head(frame, head);
  EXPECT_EQ(missing_fields(head), std::vector<std::string>{"updates"});
  frame.clear_updates();
  EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(frame, head));
}

TEST(FrameOptions, EveryFieldOfAFrameButTheUpdatesHasAnOption) {
  FrameOptions options;
  options.mode = v1::DETECTION_MODE_CCD;
  options.accuracy = v1::ACCURACY_EXACT;
  options.delta = 0.0;  // set, though it is what a frame without it would have
  options.report = v1::REPORT_ANY_HIT;
  options.ignore_separating = options.advance = options.limits = options.trial = true;
  options.advance_mode = v1::ADVANCE_MODE_PER_MESH;
  options.from_last_fraction = 0.0;
  options.edit = v1::SceneEdit();
  options.worlds = {2, 3};
  options.meshes = {4};
  const v1::Frame head = frame_head(5, options);
  EXPECT_EQ(missing_fields(head), std::vector<std::string>{"updates"});
  EXPECT_EQ(
      head.ShortDebugString(),
      "frame_id: 5 accuracy: ACCURACY_EXACT delta: 0 report: REPORT_ANY_HIT ignore_separating: true advance: true "
      "trial: true from_last_fraction: 0 mode: DETECTION_MODE_CCD edit { } worlds: 2 worlds: 3 meshes: 4 "
      "advance_mode: ADVANCE_MODE_PER_MESH limits: true");
}

TEST(FrameOptions, AHeadWithoutOptionsHasItsIdAlone) { EXPECT_EQ(frame_head(9, {}).ShortDebugString(), "frame_id: 9"); }

}  // namespace
}  // namespace collided::client
