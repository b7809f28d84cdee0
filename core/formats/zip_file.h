#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace handgraft::formats {

struct ZipMember {
  std::string name;
  std::string content;
};

/// A zip file of these members, not compressed; the same members give the same bytes (no
/// clock). Errors: InvalidInput beyond 4 GiB, zip's own limit. Source: PKWARE's APPNOTE 6.3.
std::string zipOf(const std::vector<ZipMember>& members);

/// As such files begin.
bool isZip(std::string_view bytes);

/// Gives the members of a zip file, stored or deflated, one by one as its directory lists them.
/// Errors: InvalidInput for what is no such file, breaks off, is packed in another way,
/// encrypted, or not what was written (CRC-32), and for a member that claims more than 16 MB
/// and four times the file, or all of them 64 MB and eight times: numbers that were measured
/// pack to a half, a bomb to a thousandth.
void readZip(std::string_view bytes, const std::function<void(const ZipMember&)>& take);

}  // namespace handgraft::formats
