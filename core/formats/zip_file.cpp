#include "core/formats/zip_file.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include <zlib.h>

#include "core/base/error.h"
#include "core/formats/byte_parts.h"

namespace handgraft::formats {
namespace {

// Source of all offsets: PKWARE's APPNOTE 4.3.7 (local), 4.3.12 (directory), 4.3.16 (end).
constexpr std::uint32_t kLocal = 0x04034B50;
constexpr std::uint32_t kDirectory = 0x02014B50;
constexpr std::uint32_t kEnd = 0x06054B50;
constexpr std::size_t kEntrySize = 46;
constexpr std::uint64_t kStored = 0;
constexpr std::uint64_t kDeflated = 8;
constexpr std::uint64_t kMemberOfAnyFile = 16 << 20;
constexpr std::uint64_t kLargest = std::numeric_limits<std::uint32_t>::max();

void appendNumber(std::string& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i)
    bytes += static_cast<char>((value >> (8 * i)) & 0xFFu);
}

const Bytef* bytesOf(std::string_view text) {
  return reinterpret_cast<const Bytef*>(text.data());  // zlib's type for any byte
}

std::uint64_t crcOf(std::string_view content) {
  return crc32_z(0, bytesOf(content), content.size());
}

/// What stands before a member, and (`in_directory`) in the list at the end.
std::string headOf(const ZipMember& member, bool in_directory) {
  constexpr std::uint64_t kVersion = 20;
  constexpr std::uint64_t kDay = (1 << 5) | 1;  // 1980-01-01: no clock in the bytes
  std::string head;
  appendNumber(head, in_directory ? kDirectory : kLocal, 4);
  if (in_directory) appendNumber(head, kVersion, 2);  // made by
  appendNumber(head, kVersion, 2);                    // needed
  appendNumber(head, 0, 2);                           // flags
  appendNumber(head, kStored, 2);
  appendNumber(head, 0, 2);  // time
  appendNumber(head, kDay, 2);
  appendNumber(head, crcOf(member.content), 4);
  appendNumber(head, member.content.size(), 4);
  appendNumber(head, member.content.size(), 4);
  appendNumber(head, member.name.size(), 2);
  appendNumber(head, 0, 2);  // extra field
  return head;
}

// === Reading

/// An entry of the directory.
struct Entry {
  std::string name;
  std::uint64_t flags = 0;
  std::uint64_t method = kStored;
  std::uint64_t crc = 0;
  std::uint64_t packed_size = 0;
  std::uint64_t size = 0;
  std::uint64_t begin = 0;       ///< of its local head
  std::uint64_t entry_size = 0;  ///< of the entry itself
};

/// Of a zip64 member the sizes that do not fit stand in its extra field (APPNOTE 4.5.3).
void takeLongSizes(std::string_view extra, Entry& entry) {
  constexpr std::uint64_t kZip64 = 1;
  for (std::uint64_t at = 0; at + 4 <= extra.size(); at += 4 + numberAt(extra, at + 2, 2)) {
    if (numberAt(extra, at, 2) != kZip64) continue;
    std::uint64_t next = at + 4;
    for (std::uint64_t* number : {&entry.size, &entry.packed_size, &entry.begin}) {
      if (*number != kLargest) continue;
      *number = numberAt(extra, next, 8);
      next += 8;
    }
    return;
  }
}

Entry entryAt(std::string_view bytes, std::uint64_t at) {
  if (numberAt(bytes, at, 4) != kDirectory)
    rejectInput("zip: its directory is wrong at byte {}", at);
  Entry entry;
  entry.flags = numberAt(bytes, at + 8, 2);
  entry.method = numberAt(bytes, at + 10, 2);
  entry.crc = numberAt(bytes, at + 16, 4);
  entry.packed_size = numberAt(bytes, at + 20, 4);
  entry.size = numberAt(bytes, at + 24, 4);
  const std::uint64_t name_size = numberAt(bytes, at + 28, 2);
  const std::uint64_t extra_size = numberAt(bytes, at + 30, 2);
  const std::uint64_t comment_size = numberAt(bytes, at + 32, 2);
  entry.begin = numberAt(bytes, at + 42, 4);
  entry.name = partAt(bytes, at + kEntrySize, name_size);
  takeLongSizes(partAt(bytes, at + kEntrySize + name_size, extra_size), entry);
  entry.entry_size = kEntrySize + name_size + extra_size + comment_size;
  return entry;
}

std::string inflated(std::string_view packed, const Entry& entry) {
  std::string content(static_cast<std::size_t>(entry.size), '\0');
  z_stream stream{};
  HANDGRAFT_REQUIRE(inflateInit2(&stream, -MAX_WBITS) == Z_OK);  // without zlib's own head
  stream.next_in = const_cast<Bytef*>(bytesOf(packed));          // it only reads
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(content.data());
  stream.avail_out = static_cast<uInt>(content.size());
  const int result = inflate(&stream, Z_FINISH);
  const bool is_whole = result == Z_STREAM_END && stream.total_out == entry.size;
  inflateEnd(&stream);
  if (!is_whole) rejectInput("zip: member {} cannot be unpacked", quoted(entry.name));
  return content;
}

ZipMember memberOf(std::string_view bytes, const Entry& entry) {
  const std::uint64_t most = kMemberOfAnyFile + 4 * bytes.size();
  if (entry.size > most)
    rejectInput("zip: member {} claims {} bytes; permitted are {} in a file of {}",
                quoted(entry.name), entry.size, most, bytes.size());
  constexpr std::uint64_t kEncrypted = 1;
  if ((entry.flags & kEncrypted) != 0)
    rejectInput("zip: member {} is encrypted", quoted(entry.name));
  const std::uint64_t begin = entry.begin + 30 + numberAt(bytes, entry.begin + 26, 2) +
                              numberAt(bytes, entry.begin + 28, 2);
  const std::string_view packed = partAt(bytes, begin, entry.packed_size);
  ZipMember member{entry.name, {}};
  if (entry.method == kDeflated)
    member.content = inflated(packed, entry);
  else if (entry.method == kStored && entry.packed_size == entry.size)
    member.content = packed;
  else
    rejectInput(
        "zip: member {} is packed by method {}; permitted are {} (stored) and {} "
        "(deflated)",
        quoted(entry.name), entry.method, kStored, kDeflated);
  if (crcOf(member.content) != entry.crc)
    rejectInput("zip: member {} is damaged: its checksum is not the one it was written with",
                quoted(entry.name));
  return member;
}

}  // namespace

std::string zipOf(const std::vector<ZipMember>& members) {
  std::string file;
  std::string directory;
  std::uint64_t total = 0;
  for (const ZipMember& member : members)
    total += 2 * member.name.size() + 128 + member.content.size();
  if (total > kLargest) rejectInput("a zip file of {} bytes; permitted are 4 GiB", total);
  for (const ZipMember& member : members) {
    directory += headOf(member, true);
    appendNumber(directory, 0, 2);            // comment
    appendNumber(directory, 0, 2);            // disk
    appendNumber(directory, 0, 2);            // internal attributes
    appendNumber(directory, 0, 4);            // external ones
    appendNumber(directory, file.size(), 4);  // where it begins
    directory += member.name;
    file += headOf(member, false) + member.name + member.content;
  }
  const std::size_t begin = file.size();
  file += directory;
  appendNumber(file, kEnd, 4);
  appendNumber(file, 0, 4);  // disks
  appendNumber(file, members.size(), 2);
  appendNumber(file, members.size(), 2);
  appendNumber(file, directory.size(), 4);
  appendNumber(file, begin, 4);
  appendNumber(file, 0, 2);  // comment
  return file;
}

bool isZip(std::string_view bytes) {
  return bytes.substr(0, 4) == std::string_view("PK\x03\x04", 4);
}

void readZip(std::string_view bytes, const std::function<void(const ZipMember&)>& take) {
  const std::size_t end = bytes.rfind(std::string_view("PK\x05\x06", 4));
  if (!isZip(bytes) || end == std::string_view::npos)
    rejectInput("zip: it is no zip file, or breaks off");
  const std::uint64_t count = numberAt(bytes, end + 10, 2);
  std::uint64_t at = numberAt(bytes, end + 16, 4);
  // Entries may all name the same bytes: what they take in time is bounded, too.
  const std::uint64_t most = 4 * kMemberOfAnyFile + 8 * bytes.size();
  std::uint64_t total = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Entry entry = entryAt(bytes, at);
    total += std::min(entry.size, most);
    if (total > most)
      rejectInput(
          "zip: its members claim more than the {} bytes in all that are permitted in "
          "a file of {}",
          most, bytes.size());
    take(memberOf(bytes, entry));
    at += entry.entry_size;
  }
}

}  // namespace handgraft::formats
