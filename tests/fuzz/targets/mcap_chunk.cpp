#include "bus/log/mcap_records.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {
namespace {

using namespace bus::log;

template <class Record>
void Check(Input content) {
  Record record;
  if (!ReadRecord(content, &record)) return;
  Bytes bytes;
  AppendRecord(record, &bytes);
}

// The parser of each kind of record alone: few inputs of the whole reader reach it.
void CheckRecords(Input content) {
  Check<Header>(content);
  Check<Footer>(content);
  Check<Schema>(content);
  Check<Channel>(content);
  Check<Message>(content);
  Check<Chunk>(content);
  Check<MessageIndex>(content);
  Check<ChunkIndex>(content);
  Check<Attachment>(content);
  Check<AttachmentIndex>(content);
  Check<Statistics>(content);
  Check<Metadata>(content);
  Check<MetadataIndex>(content);
  Check<SummaryOffset>(content);
  Check<DataEnd>(content);
}

}  // namespace

// Records within a chunk whose checksum is right, in a file that is cut off behind it.
void FuzzMcapChunk(Input input) {
  CheckRecords(input);
  Bytes file(kMcapMagic.begin(), kMcapMagic.end());
  AppendRecord(Header{"", "fuzz"}, &file);
  Chunk chunk;
  chunk.records.assign(input.begin(), input.end());
  chunk.uncompressed_size = chunk.records.size();
  chunk.uncompressed_crc = Crc32(chunk.records);
  AppendRecord(chunk, &file);
  FuzzMcap(file);
}

}  // namespace fuzz
