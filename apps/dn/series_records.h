#pragma once

#include <dn/blind_check/blind_record.h>
#include <dn/montecarlo/flight_record.h>
#include <dn/study/sweep.h>

#include "record_folder.h"
#include "series.h"

namespace dn::apps {

/// These functions return readers for the records of a series, for resuming a run and for merging
/// shards. A reader accepts only the seed and the labels that the series has for the number of the
/// record. `made_from` is the content of made_from.json of the series. Throws InvalidInput if it is
/// incomplete.
RecordReader<FlightRecord> FlightRecordReader(const JsonPlace& made_from);
RecordReader<BlindRecord> BlindRecordReader(const JsonPlace& made_from);
RecordReader<SweepRecord> SweepRecordReader(const JsonPlace& made_from);

/// Throws InvalidInput unless a series is as long as the sweep that it was made from.
void ExpectAllDesigns(const JsonPlace& made_from, const Series& series);

}  // namespace dn::apps
