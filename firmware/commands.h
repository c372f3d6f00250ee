#pragma once

#include "firmware/controller.h"
#include "firmware/iiod/model.h"

/// What every command that can lead to energising has in common: `VALUE TOKEN`, with the token of the lease in force.

namespace powbench::firmware {

/// The bench belongs to somebody else; its reader adds who that is and for how long.
inline constexpr std::string_view not_the_owner = "refused: the bench belongs to ";
inline constexpr std::string_view nobody_owns =
    "refused: claim the bench first, write TOKEN MS OWNER to lease";

/// First word of a text; the text loses it.
inline std::string_view take_word(std::string_view& text) {
  text = trim(text);
  std::size_t end = 0;
  while (end < text.size() && text[end] != ' ') ++end;
  const std::string_view word{text.data(), end};  // substr() could throw
  text.remove_prefix(end);
  text = trim(text);
  return word;
}

/// Takes the token off `value`. 0: it is the owner's, whose lease starts anew. Otherwise -EBUSY.
inline int admit(Controller& controller, std::string_view& value) {
  std::string_view token = value;
  value = take_word(token);
  Lease& lease = controller.lease();
  if (!lease.is_owner(token)) {
    controller.fire_control().note_refusal(lease.held() ? not_the_owner : nobody_owns);
    return -iiod::ebusy;
  }
  lease.renew();
  return 0;
}

}  // namespace powbench::firmware
