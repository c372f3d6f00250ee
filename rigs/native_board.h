#pragma once

#include "rigs/board.h"

namespace powbench::rigs {

/// The firmware compiled into this program, called directly. The texts of configuration and identity must
/// outlive the board.
std::unique_ptr<Board> make_native_board(const firmware::ControllerConfig&, const firmware::Identity&);

}  // namespace powbench::rigs
