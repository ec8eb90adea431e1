#include "bus/wire/schema.hpp"

#include "bus/topics.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {

// Two schemas as nodes declare them to the registry, then a pattern and a topic as an observer declares them.
void FuzzSchema(Input input) {
  Reader reader(input);
  const std::string a = TextOf(reader.Piece());
  const std::string b = TextOf(reader.Piece());
  std::string why;
  if (!bus::AreCompatible(a, b, &why)) Claim(!why.empty(), "a refusal says why");
  Claim(bus::AreCompatible(a, a, &why), "a schema is compatible with itself");
  const std::string pattern = TextOf(reader.Piece());
  const std::string topic = TextOf(reader.Piece());
  (void)bus::MatchesPattern(pattern, topic);
  Claim(bus::MatchesPattern("*", topic), "a star matches everything");
  (void)bus::FindTopicRule(topic);
}

}  // namespace fuzz
