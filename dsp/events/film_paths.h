#pragma once

#include "core/events.h"
#include "core/record.h"
#include "dsp/events/extract.h"
#include "dsp/filter/force.h"
#include "dsp/options.h"
#include "dsp/signal/signal.h"
#include "dsp/vibration/ring.h"

/// What the extraction went through on the films, for those who look at the vibration afterwards: the same work a
/// second time would cost as much as the events.

namespace powbench::dsp {

/// From a film to its contacts.
struct FilmPath {
  Force force;      ///< not present where the channel is missing or dead
  Ring ring;        ///< vibration taken out; may be empty
  Signal stripped;  ///< N, force less the ring
};

struct FilmPaths {
  FilmPath a, b;
  const FilmPath& of(Channel film) const { return film == Channel::pvdf_a ? a : b; }
};

/// extract_events that keeps the paths. With a filter that was not judged they are those without it.
Events extract_events(const Record&, const ExtractOptions&, const RunBoth& both, FilmPaths&);

}  // namespace powbench::dsp
