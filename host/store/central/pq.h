#pragma once

#include <libpq-fe.h>

#include "core/late_library.h"
#include "host/store/central/central.h"

namespace powbench::host::postgres {

/// The client of PostgreSQL, loaded by the first connection.
struct Pq {
  LateLibrary library{POWBENCH_LIBPQ};
  POWBENCH_LATE(PQclear);
  POWBENCH_LATE(PQconnectdbParams);
  POWBENCH_LATE(PQconninfoFree);
  POWBENCH_LATE(PQconninfoParse);
  POWBENCH_LATE(PQenterPipelineMode);
  POWBENCH_LATE(PQerrorMessage);
  POWBENCH_LATE(PQexec);
  POWBENCH_LATE(PQexitPipelineMode);
  POWBENCH_LATE(PQfinish);
  POWBENCH_LATE(PQfreemem);
  POWBENCH_LATE(PQgetResult);
  POWBENCH_LATE(PQgetisnull);
  POWBENCH_LATE(PQgetlength);
  POWBENCH_LATE(PQgetvalue);
  POWBENCH_LATE(PQntuples);
  POWBENCH_LATE(PQparameterStatus);
  POWBENCH_LATE(PQpingParams);
  POWBENCH_LATE(PQpipelineSync);
  POWBENCH_LATE(PQresultErrorField);
  POWBENCH_LATE(PQresultErrorMessage);
  POWBENCH_LATE(PQresultStatus);
  POWBENCH_LATE(PQsendPrepare);
  POWBENCH_LATE(PQsendQueryPrepared);
  POWBENCH_LATE(PQsetNoticeProcessor);
  POWBENCH_LATE(PQstatus);
};
/// Throws ServerError if it is not installed.
inline const Pq& pq() try {
  static const Pq one;
  return one;
} catch (const std::runtime_error& e) {
  throw ServerError(std::string("the client of PostgreSQL ") + e.what() + "; install libpq5");
}

}  // namespace powbench::host::postgres
