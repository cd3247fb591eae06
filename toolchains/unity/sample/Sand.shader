// A grain: a square that faces the camera, cut to a circle and shaded like a sphere in the room's light. Colours are
// linear, and so must be the project's colour space.
Shader "Sandglass/Sand" {
  SubShader {
    Tags { "RenderType" = "Opaque" "Queue" = "AlphaTest" }
    Pass {
      CGPROGRAM
      #pragma target 4.5
      #pragma vertex vertex
      #pragma fragment fragment
      #include "UnityCG.cginc"

      StructuredBuffer<float4> _Older, _Newer;  // position and speed
      float3 _Origin, _ToLight;  // in Unity's world
      float3 _Sun, _Ambient;
      float _Radius, _Nearer, _Share, _Span;  // _Nearer: as Table.shader has it; _Share: of the newer; _Span: seconds between

      struct Corner { float4 position : SV_POSITION; float2 at : TEXCOORD0; };

      Corner vertex(uint index : SV_VertexID) {
        static const float2 corners[6] = { float2(-1, -1), float2(1, -1), float2(1, 1), float2(-1, -1), float2(1, 1), float2(-1, 1) };
        float4 older = _Older[index / 6], newer = _Newer[index / 6];
        // One that went further than its speeds explain is new, removed, or another of that number.
        float share = distance(older.xyz, newer.xyz) < _Span * (older.w + newer.w) + 0.01 ? _Share : 1;
        float3 place = _Origin + lerp(older.xyz, newer.xyz, share) * float3(1, 1, -1);  // right-handed to left-handed
        float4 view = mul(UNITY_MATRIX_V, float4(place, 1));
        Corner corner;
        corner.at = corners[index % 6];
        view.xy += _Radius * corner.at;
        corner.position = mul(UNITY_MATRIX_P, float4(view.xyz * _Nearer, 1));
        return corner;
      }

      fixed4 fragment(Corner corner) : SV_Target {
        float r2 = dot(corner.at, corner.at);
        clip(1 - r2);
        float3 normal = float3(corner.at, sqrt(1 - r2));  // in view space
        float facing = saturate(dot(normal, mul((float3x3)UNITY_MATRIX_V, _ToLight)));
        return fixed4(float3(0.53, 0.34, 0.13) * (_Ambient + _Sun * facing), 1);
      }
      ENDCG
    }
  }
}
