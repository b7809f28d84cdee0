#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "idl/fields.h"

/// Valid messages at random, by the tables of their fields.
namespace handgraft::test {

class RandomMessage {
 public:
  explicit RandomMessage(unsigned seed) : random_(seed) {}

  template <class Message>
  Message make() {
    Message message;
    fill(idl::typeOf<Message>(), &message);
    return message;
  }

 private:
  std::size_t below(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_);
  }

  /// Edges of the range as often as what lies between.
  template <class Number>
  Number number(const idl::Field& field) {
    const Number least =
        field.least > static_cast<double>(std::numeric_limits<Number>::lowest())
            ? static_cast<Number>(field.least)
            : std::numeric_limits<Number>::lowest();
    const Number most = field.most < static_cast<double>(std::numeric_limits<Number>::max())
                            ? static_cast<Number>(field.most)
                            : std::numeric_limits<Number>::max();
    switch (below(4)) {
      case 0:
        return least;
      case 1:
        return most;
      default:
        break;
    }
    if constexpr (std::is_integral_v<Number>) {
      return static_cast<Number>(std::uniform_int_distribution<long long>(
          std::max<long long>(-1'000'000, static_cast<long long>(std::max<double>(
                                              static_cast<double>(least), -1e6))),
          static_cast<long long>(std::min<double>(static_cast<double>(most), 1e6)))(random_));
    } else {
      if (field.infinite && below(3) == 0) return below(2) ? INFINITY : -INFINITY;
      const Number value = static_cast<Number>(std::normal_distribution<double>()(random_));
      return std::min(std::max(value, least), most);
    }
  }

  void fillValue(const idl::Type& type, void* value, const idl::Field& field) {
    using idl::Kind;
    switch (type.kind) {
      case Kind::kBoolean:
        *static_cast<bool*>(value) = below(2) == 1;
        return;
      case Kind::kOctet:
        *static_cast<std::uint8_t*>(value) = static_cast<std::uint8_t>(below(256));
        return;
      case Kind::kInt32:
        *static_cast<std::int32_t*>(value) = number<std::int32_t>(field);
        return;
      case Kind::kUint32:
        *static_cast<std::uint32_t*>(value) = number<std::uint32_t>(field);
        return;
      case Kind::kInt64:
        *static_cast<std::int64_t*>(value) = number<std::int64_t>(field);
        return;
      case Kind::kUint64:
        *static_cast<std::uint64_t*>(value) = number<std::uint64_t>(field);
        return;
      case Kind::kFloat:
        *static_cast<float*>(value) = number<float>(field);
        return;
      case Kind::kDouble:
        *static_cast<double*>(value) = number<double>(field);
        return;
      case Kind::kString: {
        static const std::vector<std::string> some_texts = {"", "thumb", "a \"b\"\n\\",
                                                            "\xC3\xA4"};
        *static_cast<std::string*>(value) = some_texts[below(some_texts.size())];
        return;
      }
      case Kind::kEnum: {
        const std::uint32_t one = type.names[below(type.names.size())].value;
        std::memcpy(value, &one, sizeof(one));
        return;
      }
      case Kind::kSequence:
        type.resize(value,
                    below(type.bound == 0 ? 4 : std::min<std::size_t>(type.bound + 1, 4)));
        [[fallthrough]];
      case Kind::kArray:
        for (std::size_t i = 0; i < type.size(value); ++i)
          fillValue(*type.element, type.at(value, i), field);
        return;
      case Kind::kStruct:
      case Kind::kUnion:
        return fill(type, value);
    }
  }

  void fill(const idl::Type& type, void* message) {
    if (type.kind == idl::Kind::kUnion) {
      const auto& names = type.discriminator->names;
      const idl::Field* chosen = nullptr;
      while (chosen == nullptr) {
        const std::uint32_t label = names[below(names.size())].value;
        chosen = idl::chosenOf(type, label);
        if (chosen != nullptr) type.choose(message, label);
      }
      return fillValue(*chosen->type, chosen->in(message), *chosen);
    }
    if (std::string_view(type.name) == "Nothing") return;
    for (const idl::Field& field : type.fields)
      fillValue(*field.type, field.in(message), field);
  }

  std::mt19937 random_;
};

}  // namespace handgraft::test
