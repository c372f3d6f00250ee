#pragma once

#include "rigs/rig.h"

namespace powbench::rigs {

/// Time a rig gets to answer the first connection.
inline constexpr std::chrono::milliseconds connect_limit{2500};

/// Time a rig gets to answer one request: its server must answer within that, or the connection is thrown away.
inline constexpr std::chrono::milliseconds request_limit{2000};

/// The same where a shot's own limit is all but over: its record may be there.
inline constexpr std::chrono::milliseconds least_connection{1000};

/// Connects through libiio to `uri` ("ip:127.0.0.7"). Throws RigError within `limit`.
std::unique_ptr<Rig> connect_iio(const std::string& uri, std::chrono::milliseconds limit = connect_limit,
                                 std::chrono::milliseconds request = request_limit);

}  // namespace powbench::rigs
