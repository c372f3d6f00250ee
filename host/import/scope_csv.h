#pragma once

#include <string>
#include <string_view>

#include "host/config/csv_table.h"

/// CSV as oscilloscopes write it: lines of settings ahead of the numbers, units in a line of their own or inside the
/// names, the clock as two numbers in the settings.

namespace powbench::host {

/// True where read_csv cannot be meant: the first line does not name columns of numbers that begin in the second one,
/// or names them as only an instrument does (`CH1(V)`, `C1 in V`, `CH1V` with `t0 = ...`).
bool is_scope_csv(std::string_view text);

/// Columns `time [s]`, `NAME [UNIT]`, ... from the preambles of Tektronix (TDS: settings beside the numbers; DPO, MDO
/// and MSO: above them), Keysight (InfiniiVision, Infiniium), Rigol (DS1000Z with Start and Increment; MSO5000 with
/// t0 and tInc), Rohde & Schwarz (RTB, `in s,C1 in V`), LeCroy (one segment), Siglent, Pico, and alike: the numbers
/// begin where three lines in a row hold equally many numbers; the last line above them that has a name for each
/// column names them; a line of units stands there or behind; what is left are settings, `NAME,VALUE`. Separators and
/// decimal commas as in read_csv.
///
/// What the file leaves open and how it was taken (a unit that is not stated is V) stands in `notes`. Throws
/// BadInput, one sentence: a preamble that names no columns or gives no clock is called that, with its lines; several
/// segments; a row that is none.
CsvTable read_scope_csv(std::string_view text, const std::string& file);

}  // namespace powbench::host
