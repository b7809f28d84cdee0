#pragma once

#include "idl/datagrams/rtps.h"

/// Whether submessages are well formed, each by itself.
namespace handgraft::idl::rtps {

/// Of the kinds that our programs and ROS 2's use.
bool isPassed(std::uint8_t kind);

/// Where what was written of DATA begins, `fixed` bytes of a head at least; nothing if what
/// stands before it is malformed.
std::optional<std::size_t> payloadOf(const Piece& body, std::uint8_t flags, std::size_t fixed);

/// DATA; of discovery's own writers with what it says. `source`: the GUID prefix it came by.
bool isData(const Piece& body, std::uint8_t flags, Bytes source);

/// DATA of any shape by which one of our clients announces itself.
bool announcesAClient(const Piece& body, std::uint8_t flags);

bool isDataFragment(const Piece& body, std::uint8_t flags);

/// What Fast DDS needs in an ACKNACK of Cyclone DDS (said at its definition). `whole`: sound,
/// with its header.
void beginAnew(std::span<std::uint8_t> whole);

/// Type information becomes padding: types meet by name alone. `whole`: DATA that is sound.
void blankTypes(std::span<std::uint8_t> whole);

}  // namespace handgraft::idl::rtps
