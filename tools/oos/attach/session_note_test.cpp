#include "tools/oos/attach/session_note.hpp"

#include <gtest/gtest.h>

namespace oos {
namespace {

TEST(SessionNote, KeepsQuotesBackslashesAndLineEndsInNames) {
  SessionNote note;
  note.registry = "tcp://127.0.0.1:7450";
  note.session = "18446744073709551615";
  note.pid = 42;
  note.out = "out/a \"quoted\" run";
  note.keys = "keys\\of\\it";
  note.scenario = "two\nlines/scenario.xml";
  const auto read = ParseSessionNote(ToJson(note));
  ASSERT_TRUE(read) << read.error().detail;
  EXPECT_EQ(read->registry, note.registry);
  EXPECT_EQ(read->session, note.session);
  EXPECT_EQ(read->pid, note.pid);
  EXPECT_EQ(read->out, note.out);
  EXPECT_EQ(read->keys, note.keys);
  EXPECT_EQ(read->scenario, note.scenario);
}

TEST(SessionNote, WithoutRegistryOrSessionIsNone) {
  for (const char* text :
       {"", "{", "[]", "{}", R"({"registry": "tcp://127.0.0.1:1"})", R"({"registry": 1, "session": 2})"}) {
    EXPECT_FALSE(ParseSessionNote(text)) << text;
  }
}

}  // namespace
}  // namespace oos
