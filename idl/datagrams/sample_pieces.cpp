#include "idl/datagrams/sample_pieces.h"

#include <algorithm>
#include <utility>

namespace handgraft::idl {

std::optional<std::vector<std::uint8_t>> SamplePieces::add(const Piece& piece) {
  if (piece.first == 0 || piece.size == 0 || piece.whole == 0 || piece.whole > kLargest)
    return std::nullopt;
  const auto now = Clock::now();
  while (!begun_.empty() && now - begun_.front().grown > kLongest)
    begun_.pop_front();
  auto at = std::find_if(begun_.begin(), begun_.end(), [&](const Begun& one) {
    return one.source == piece.source && one.number == piece.number;
  });
  if (at != begun_.end() && (at->size != piece.size || at->bytes.size() != piece.whole))
    return std::nullopt;
  const std::size_t count = (piece.whole + piece.size - 1) / piece.size;
  if (at == begun_.end()) {
    if (begun_.size() >= kMostAtOnce) begun_.pop_front();
    begun_.push_back({piece.source, piece.number, piece.size,
                      std::vector<std::uint8_t>(piece.whole), std::vector<bool>(count), now});
    at = std::prev(begun_.end());
  }
  at->grown = now;
  begun_.splice(begun_.end(), begun_, at);
  std::span<const std::uint8_t> rest = piece.bytes;
  for (std::size_t i = piece.first - 1; i < count && !rest.empty(); ++i) {
    const std::size_t begin = i * piece.size;
    const std::size_t length = std::min<std::size_t>(piece.size, piece.whole - begin);
    if (rest.size() < length) break;
    std::copy_n(rest.begin(), length, at->bytes.begin() + static_cast<std::ptrdiff_t>(begin));
    at->is_there[i] = true;
    rest = rest.subspan(length);
  }
  if (std::find(at->is_there.begin(), at->is_there.end(), false) != at->is_there.end())
    return std::nullopt;
  auto whole = std::move(at->bytes);
  begun_.erase(at);
  return whole;
}

}  // namespace handgraft::idl
