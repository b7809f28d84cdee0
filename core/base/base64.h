#pragma once

#include <string>
#include <string_view>

namespace handgraft {

/// Bytes as text (RFC 4648, section 4, with padding; by libcrypto), four letters for three
/// bytes.
std::string base64Of(std::string_view bytes);

/// Errors: InvalidInput if `text` is not such a text.
std::string bytesOfBase64(std::string_view text);

}  // namespace handgraft
