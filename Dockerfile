FROM python:3.11-slim
COPY . /src
RUN pip install --no-cache-dir "/src[report,plot,parquet]" && rm -rf /src
ENV MPLCONFIGDIR=/tmp
USER nobody
WORKDIR /work
ENTRYPOINT ["verne-post"]
