#pragma once

#include <dn/blind_check/blind_record.h>
#include <dn/montecarlo/flight_record.h>
#include <dn/study/sweep.h>

#include "record_folder.h"
#include "series.h"

namespace dn::apps {

/// Readers of the records of a series, the same for a run that is taken up and for shards that are
/// merged: number, seed and labels are those that the series gives this number. `made_from` is what
/// made_from.json of the series holds; what it lacks is refused by InvalidInput.
RecordReader<FlightRecord> FlightRecordReader(const JsonPlace& made_from);
RecordReader<BlindRecord> BlindRecordReader(const JsonPlace& made_from);
RecordReader<SweepRecord> SweepRecordReader(const JsonPlace& made_from);

/// Throws InvalidInput where a series is not as long as the sweep that it was made from.
void ExpectAllDesigns(const JsonPlace& made_from, const Series& series);

}  // namespace dn::apps
